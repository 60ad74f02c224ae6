//! Spectra as people's files have them: two columns (`.csv`; `.spd` of PBRT, Mitsuba and lamp makers), or a data file of Radiance (`.dat`,
//! what its `specfile` names).
//!
//! Two columns are wavelength in nm and value, parted by a comma, a semicolon or blanks, `#` before comments, one optional line of column
//! names. A data file of one dimension is `1`, then the first wavelength, the last and how many (or `0 0 n` and n wavelengths), then the
//! values; wavelengths may run down.

use super::Spectrum;
use crate::error::printable;
use crate::{Result, invalid};

/// Suffixes that make a name a file's.
const SUFFIXES: [&str; 3] = [".csv", ".spd", ".dat"];
/// Numbers of a data file at most.
const MOST: usize = 1 << 20;

/// Is it the name of a file, and not that of a built-in spectrum?
pub fn is_file(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    SUFFIXES.iter().any(|s| name.ends_with(s))
}

/// The spectrum of a file's text; the name's suffix tells what it may be.
///
/// ```
/// use luxpipe::spectral::text::parse;
/// assert_eq!(parse("a.spd", "# lamp\n400 0\n500 8\n").unwrap().at(450.0), 4.0);
/// assert_eq!(parse("a.dat", "1\n500 400 3\n8 4 0\n").unwrap().at(475.0), 6.0);
/// ```
///
/// # Errors
/// A line that is no pair of numbers, wavelengths that do not ascend, a data file of another shape.
pub fn parse(name: &str, text: &str) -> Result<Spectrum> {
    let dat = name.to_ascii_lowercase().ends_with(".dat");
    let first = text.lines().map(|l| l.split('#').next().unwrap_or("").trim()).find(|l| !l.is_empty());
    let alone = first.is_some_and(|l| l.split_ascii_whitespace().count() == 1 && l.parse::<f64>().is_ok());
    if dat && alone { data_file(text) } else { columns(text) }
}

/// Two columns.
pub fn columns(text: &str) -> Result<Spectrum> {
    let mut points = Vec::new();
    let mut named = false;
    for (n, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        let parted = |c: char| c == ',' || c == ';' || c.is_ascii_whitespace();
        let fields = match line.contains([',', ';']) {
            true => line.split([',', ';']).map(str::trim).collect::<Vec<_>>(),
            false => line.split(parted).filter(|f| !f.is_empty()).collect(),
        };
        let numbers: Option<Vec<f64>> = fields.iter().map(|f| f.parse().ok()).collect();
        match numbers.as_deref() {
            Some([nm, value]) => points.push((*nm, *value)),
            None if points.is_empty() && !named => named = true,
            _ => {
                let shown = printable(line.as_bytes());
                return invalid!("line {}: expected 'wavelength_nm,value', got '{shown}'", n + 1);
            }
        }
    }
    Spectrum::from_points(points)
}

/// Radiance's data file of one dimension.
fn data_file(text: &str) -> Result<Spectrum> {
    let mut numbers = Vec::new();
    for (n, line) in text.lines().enumerate() {
        for word in line.split('#').next().unwrap_or("").split_ascii_whitespace() {
            match word.parse::<f64>() {
                Ok(x) if x.is_finite() && numbers.len() < MOST => numbers.push(x),
                _ => return invalid!("line {}: '{}' is no number of a data file", n + 1, printable(word.as_bytes())),
            }
        }
    }
    let wrong =
        "expected a data file of one dimension: 1, then first and last wavelength in nm and how many, then the values";
    let [dimensions, from, to, count, rest @ ..] = &numbers[..] else { return invalid!("{wrong}") };
    let n = *count as usize;
    if *dimensions != 1.0 || count.fract() != 0.0 || !(1.0..=MOST as f64).contains(count) {
        return invalid!("{wrong}");
    }
    let (nm, values): (Vec<f64>, &[f64]) = if *from == 0.0 && *to == 0.0 {
        if rest.len() < n {
            return invalid!("{wrong}");
        }
        (rest[..n].to_vec(), &rest[n..])
    } else {
        let step = if n > 1 { (to - from) / (n - 1) as f64 } else { 0.0 };
        ((0..n).map(|i| from + step * i as f64).collect(), rest)
    };
    if values.len() != n {
        return invalid!("has {} values for {n} wavelengths", values.len());
    }
    let mut points: Vec<(f64, f64)> = nm.into_iter().zip(values.iter().copied()).collect();
    if points.first().zip(points.last()).is_some_and(|(a, b)| a.0 > b.0) {
        points.reverse();
    }
    Spectrum::from_points(points)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_all_kinds_are_read() {
        let rising = Spectrum::from_points(vec![(400.0, 1.0), (500.0, 3.0)]).unwrap();
        for (name, text) in [
            ("a.csv", "# paint\nwavelength_nm,value\n400,1\n500,3\n"),
            ("a.SPD", "400\t1\n500   3\n"),
            ("a.spd", "nm W\n400 1\n500 3\n"),
            ("a.csv", "400;1\r\n500;3\r\n"),
            ("a.dat", "400 1\n500 3\n"),
            ("a.dat", "# lamp\n1\n400 500 2\n1 3\n"),
            ("a.dat", "1\n500 400 2\n3\n1 # end\n"),
            ("a.dat", "1 \n0 0 2 400 500\n1 3\n"),
        ] {
            assert_eq!(parse(name, text).unwrap(), rising, "{name} {text}");
        }
        for (name, text, word) in [
            ("a.csv", "400,1,2\n", "line 1"),
            ("a.spd", "400 1\nhalf 2\n", "line 2"),
            ("a.dat", "2\n400 500 2\n", "one dimension"),
            ("a.dat", "1\n400 500 1e30\n", "one dimension"),
            ("a.dat", "1\n400 500 3\n1 2\n", "has 2 values for 3"),
            ("a.dat", "1\n0 0 5 400 500\n", "one dimension"),
            ("a.dat", "1\n400 500 x\n", "'x' is no number"),
            ("a.dat", "1", "one dimension"),
            ("a.csv", "", "at least one point"),
        ] {
            let message = parse(name, text).unwrap_err().to_string();
            assert!(message.contains(word), "{text}: {message}");
        }
        assert!(is_file("Lamp.SPD") && is_file("a.dat") && !is_file("D65"));
    }
}
