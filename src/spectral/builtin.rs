//! The tables of spectra/, embedded at build time. A name is a file's name without `.csv`.

use super::Spectrum;
use crate::{Error, Result};

static FILES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/spectra.rs"));

/// Names of all built-in tables, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    FILES.iter().map(|f| f.0)
}

/// The text of a built-in table, comments included: `illuminant_FL11` is spectra/illuminant_FL11.csv. Illuminants also
/// answer to their short name (`A`, `D65`, `FL11`, `LED-B3`) in any case.
pub fn text(name: &str) -> Option<&'static str> {
    let find = |n: &str| FILES.iter().find(|f| f.0.eq_ignore_ascii_case(n)).map(|f| f.1);
    find(name).or_else(|| find(&format!("illuminant_{name}")))
}

/// The built-in table of that name.
pub fn spectrum(name: &str) -> Result<Spectrum> {
    let text = text(name).ok_or_else(|| {
        let close = nearest(name).map(|n| format!("; did you mean '{n}'?")).unwrap_or_default();
        Error::Invalid(format!("no built-in spectrum '{}'{close}", crate::error::printable(name.as_bytes())))
    })?;
    Spectrum::from_csv(text).map_err(|e| e.within(name))
}

fn nearest(name: &str) -> Option<&'static str> {
    let (best, distance) = names().map(|n| (n, edits(&name.to_lowercase(), &n.to_lowercase()))).min_by_key(|p| p.1)?;
    (distance <= 1 + name.len() / 3).then_some(best)
}

/// Levenshtein distance.
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let substitute = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = substitute.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    #[test]
    fn every_table_parses_and_cites_its_source() {
        assert!(super::names().count() > 80);
        for name in super::names() {
            super::spectrum(name).unwrap();
            let text = super::text(name).unwrap();
            assert!(text.starts_with("# ") && text.to_lowercase().contains("source"), "{name} names no source");
        }
    }
}
