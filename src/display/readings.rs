//! Readings of patches: CSV with the columns r,g,b (codes) and x,y,Y (chromaticity, cd/m2).

use crate::color::Xy;
use crate::error::printable;
use crate::{Error, Result, invalid};

const COLUMNS: [&str; 6] = ["r", "g", "b", "x", "y", "Y"];
/// A luminance that no display has, cd/m2.
const TOO_BRIGHT: f64 = 1e6;

/// One patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Line of the file.
    pub line: usize,
    /// Codes 0..1.
    pub code: [f64; 3],
    /// Light, Y in cd/m2.
    pub xyz: [f64; 3],
}

/// All patches of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// In the order of the file.
    pub list: Vec<Reading>,
    /// What the file's codes count to: 1 or 255.
    pub full: f64,
}

impl Readings {
    /// From CSV: comment lines from `#`, a line of column names in any order, then a line a patch. Codes go to 255 when one
    /// of them is above 1.
    pub fn parse(text: &str) -> Result<Readings> {
        let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim_start_matches('\u{feff}').trim()));
        let mut lines = lines.by_ref().filter(|(_, l)| !l.is_empty() && !l.starts_with('#'));
        let Some((n, head)) = lines.next() else {
            return invalid!("no readings; expected a line r,g,b,x,y,Y and patches");
        };
        let order = columns(head).map_err(|e| e.within(&format!("line {n}")))?;
        let mut list = Vec::new();
        for (line, text) in lines {
            list.push(reading(line, text, &order).map_err(|e| e.within(&format!("line {line}")))?);
        }
        if list.is_empty() {
            return invalid!("no readings below the line of column names");
        }
        let top = list.iter().flat_map(|r| r.code).fold(0f64, f64::max);
        let full = if top > 1.0 { 255.0 } else { 1.0 };
        list.iter_mut().for_each(|r| r.code = r.code.map(|c| c / full));
        Ok(Readings { list, full })
    }

    /// Mean light of all readings of a code.
    pub fn mean(&self, code: [f64; 3]) -> Option<[f64; 3]> {
        let of: Vec<_> = self.list.iter().filter(|r| r.code == code).map(|r| r.xyz).collect();
        let n = of.len() as f64;
        (!of.is_empty()).then(|| [0, 1, 2].map(|i| of.iter().map(|x| x[i]).sum::<f64>() / n))
    }
}

/// Where each of [`COLUMNS`] stands.
fn columns(head: &str) -> Result<[usize; 6]> {
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    let expected = COLUMNS.join(",");
    if let Some(name) = names.iter().find(|n| !COLUMNS.contains(n)) {
        return invalid!("'{}' is no column; the first line is {expected}", printable(name.as_bytes()));
    }
    let mut order = [0; 6];
    for (place, name) in order.iter_mut().zip(COLUMNS) {
        let found: Vec<usize> = (0..names.len()).filter(|i| names[*i] == name).collect();
        *place = match found[..] {
            [one] => one,
            [] => return invalid!("column '{name}' is missing; the first line is {expected}"),
            _ => return invalid!("column '{name}' is there twice"),
        };
    }
    Ok(order)
}

fn reading(line: usize, text: &str, order: &[usize; 6]) -> Result<Reading> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    if cells.len() != COLUMNS.len() {
        return invalid!("{} values, expected 6: {}", cells.len(), COLUMNS.join(","));
    }
    let mut v = [0.0; 6];
    for ((v, place), name) in v.iter_mut().zip(order).zip(COLUMNS) {
        let number = cells[*place].parse().ok().filter(|x: &f64| x.is_finite());
        let shown = printable(cells[*place].as_bytes());
        *v = number.ok_or_else(|| Error::Invalid(format!("{name} '{shown}' is not a number")))?;
    }
    let [r, g, b, x, y, luminance] = v;
    if let Some(c) = [r, g, b].iter().find(|c| !(0.0..=255.0).contains(*c)) {
        return invalid!("code {c} must be 0 to 1, or 0 to 255");
    }
    if !(0.0..=TOO_BRIGHT).contains(&luminance) {
        return invalid!("Y {luminance} must be a luminance from 0 in cd/m2");
    }
    let xy = Xy { x, y };
    // No light has no chromaticity, whatever a meter prints.
    if luminance > 0.0 && !xy.is_physical() {
        return invalid!("chromaticity {xy} lies outside the triangle x >= 0, y > 0, x + y <= 1");
    }
    let xyz = if luminance > 0.0 { xy.xyz().map(|c| c * luminance) } else { [0.0; 3] };
    Ok(Reading { line, code: [r, g, b], xyz })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_come_in_any_order_and_bytes_are_codes() {
        let a = Readings::parse("# meter\nr,g,b,x,y,Y\n0,0.5,1,0.3127,0.329,50\n0,0,0,0,0,0\n").unwrap();
        let b = Readings::parse("Y, x, y, b, g, r\r\n50,0.3127,0.329,255,127.5,0\r\n0,nan,0,0,0,0\r\n");
        assert!(b.unwrap_err().to_string().contains("line 3: x 'nan' is not a number"));
        let b = Readings::parse("Y, x, y, b, g, r\r\n\r\n50,0.3127,0.329,255,127.5,0\r\n").unwrap();
        assert_eq!((a.list[0].code, a.list[0].xyz, a.full), (b.list[0].code, b.list[0].xyz, 1.0));
        assert_eq!((b.full, b.list[0].line, a.list[1].xyz), (255.0, 3, [0.0; 3]));
    }
}
