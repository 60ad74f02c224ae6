//! What charts are drawn from: tone curves, histograms of log luminance, tables of named columns.

use crate::error::printable;
use crate::plot::Bar;
use crate::{Error, Result, invalid};

/// Lines with something on them and their numbers from 1; what begins with # is a comment.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let trimmed = text.lines().enumerate().map(|(n, line)| (n + 1, line.trim()));
    trimmed.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'))
}

/// Two numbers separated by blanks.
fn pair(line: &str) -> Option<(f64, f64)> {
    let mut words = line.split_ascii_whitespace();
    let pair = (words.next()?.parse().ok()?, words.next()?.parse().ok()?);
    words.next().is_none().then_some(pair)
}

fn pairs(text: &str, expected: &str) -> Result<Vec<(f64, f64)>> {
    let read = |(n, line): (usize, &str)| {
        let wrong = || Error::Invalid(format!("line {n}: expected {expected}, got '{}'", printable(line.as_bytes())));
        pair(line).ok_or_else(wrong)
    };
    lines(text).map(read).collect()
}

/// A tone curve as `pcond -x` writes it: lines of world and display luminance, cd/m2.
pub fn curve(text: &str) -> Result<Vec<(f64, f64)>> {
    let points = pairs(text, "world and display luminance in cd/m2, two numbers")?;
    if points.is_empty() { invalid!("no line of world and display luminance in cd/m2") } else { Ok(points) }
}

/// A histogram is text when its first line is two numbers.
pub fn is_histogram(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    !text.starts_with("#?") && lines(&text).next().is_some_and(|(_, line)| pair(line).is_some())
}

/// Bars of a ready histogram: lines of log10 luminance (the middle of a step) and count, in even steps. Left end and right
/// end in log10 cd/m2, height in percent of all counts.
pub fn histogram(text: &str) -> Result<Vec<Bar>> {
    let rows = pairs(text, "log10 luminance and a count, two numbers")?;
    let [first, second, ..] = rows[..] else { return invalid!("a histogram needs at least two lines") };
    let step = second.0 - first.0;
    let numbers = lines(text).map(|(n, _)| n);
    for ((row, before), n) in rows.iter().skip(1).zip(&rows).zip(numbers.skip(1)) {
        let even = (row.0 - before.0 - step).abs() <= 0.02 * step;
        if !(step > 0.0 && even) {
            return invalid!("line {n}: log10 luminance must rise in even steps, got {} after {}", row.0, before.0);
        }
    }
    if let Some((row, n)) = rows.iter().zip(lines(text)).find(|(row, _)| !(row.1 >= 0.0 && row.1.is_finite())) {
        return invalid!("line {}: a count is finite and not below 0, got {}", n.0, row.1);
    }
    let total: f64 = rows.iter().map(|r| r.1).sum();
    if total <= 0.0 {
        return invalid!("all counts are 0");
    }
    Ok(rows.iter().map(|(x, count)| (x - step / 2.0, x + step / 2.0, 100.0 * count / total)).collect())
}

/// Steps of [`Luminances`] a decade.
const STEPS: i32 = 20;
/// Decades that are counted; what lies beyond counts as the outermost.
const DECADES: (i32, i32) = (-10, 20);

/// Counts of log10 luminance, in steps of 0.05.
pub struct Luminances {
    counts: Vec<u64>,
    /// Pixels whose luminance is not above 0 or not finite.
    pub dark: u64,
}

impl Default for Luminances {
    fn default() -> Self {
        Luminances { counts: vec![0; ((DECADES.1 - DECADES.0) * STEPS) as usize], dark: 0 }
    }
}

impl Luminances {
    /// Counts one luminance, cd/m2.
    pub fn add(&mut self, luminance_cd_m2: f32) {
        if !(luminance_cd_m2 > 0.0 && luminance_cd_m2.is_finite()) {
            self.dark += 1;
            return;
        }
        let step = (f64::from(luminance_cd_m2).log10() * f64::from(STEPS)).floor() as i32 - DECADES.0 * STEPS;
        let last = self.counts.len() as i32 - 1;
        self.counts[step.clamp(0, last) as usize] += 1;
    }

    /// From the first step with a pixel in it to the last, as [`histogram`] gives them; none without any pixel.
    pub fn bars(&self) -> Vec<Bar> {
        let total: u64 = self.counts.iter().sum();
        let filled = |n: &u64| *n > 0;
        let (Some(first), Some(last)) = (self.counts.iter().position(filled), self.counts.iter().rposition(filled))
        else {
            return Vec::new();
        };
        let end = |i: usize| f64::from(i as i32 + DECADES.0 * STEPS) / f64::from(STEPS);
        (first..=last).map(|i| (end(i), end(i + 1), 100.0 * self.counts[i] as f64 / total as f64)).collect()
    }
}

/// CSV with a line of names: cells separated by commas, no quotes.
#[derive(Clone, Debug)]
pub struct Table {
    names: Vec<String>,
    /// Each with its line number.
    rows: Vec<(usize, Vec<String>)>,
}

impl Table {
    /// From a file's text.
    pub fn parse(text: &str) -> Result<Table> {
        let cells = |line: &str| line.split(',').map(|c| c.trim().to_string()).collect::<Vec<_>>();
        let mut lines = lines(text.trim_start_matches('\u{feff}'));
        let Some((n, first)) = lines.next() else { return invalid!("expected a line of column names") };
        let names = cells(first);
        if names.iter().any(String::is_empty) || names.iter().all(|n| n.parse::<f64>().is_ok()) {
            return invalid!("line {n}: expected column names, got '{}'", printable(first.as_bytes()));
        }
        let rows: Vec<(usize, Vec<String>)> = lines.map(|(n, line)| (n, cells(line))).collect();
        match rows.iter().find(|r| r.1.len() != names.len()) {
            Some((n, row)) => invalid!("line {n}: expected {} cells, got {}", names.len(), row.len()),
            None => Ok(Table { names, rows }),
        }
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Cells of a column.
    pub fn words(&self, name: &str) -> Result<Vec<&str>> {
        let Some(i) = self.names.iter().position(|n| n == name) else {
            let names = printable(self.names.join(", ").as_bytes());
            return invalid!("no column '{}'; there are {names}", printable(name.as_bytes()));
        };
        Ok(self.rows.iter().map(|r| r.1[i].as_str()).collect())
    }

    /// Numbers of a column; an empty cell is NaN.
    pub fn numbers(&self, name: &str) -> Result<Vec<f64>> {
        let read = |(word, (n, _)): (&str, &(usize, Vec<String>))| match word {
            "" => Ok(f64::NAN),
            word => word.parse().map_err(|_| {
                let (name, word) = (printable(name.as_bytes()), printable(word.as_bytes()));
                Error::Invalid(format!("line {n}: expected a number in column '{name}', got '{word}'"))
            }),
        };
        self.words(name)?.into_iter().zip(&self.rows).map(read).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminances_fall_into_steps_of_a_twentieth_decade() {
        let mut l = Luminances::default();
        [1.0, 1.1, 9.99, 0.0, -1.0, f32::NAN, f32::INFINITY].iter().for_each(|x| l.add(*x));
        let bars = l.bars();
        assert_eq!((l.dark, bars.len()), (4, 20));
        assert_eq!((bars[0], bars[19]), ((0.0, 0.05, 200.0 / 3.0), (0.95, 1.0, 100.0 / 3.0)));
        assert!(Luminances::default().bars().is_empty());
    }
}
