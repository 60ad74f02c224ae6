//! Numbers, names and spectra as TOML has them.

use crate::spectral::Spectrum;

/// A number to twelve digits, as `xform` prints them: what rounding left behind goes.
///
/// Digits beyond the twelfth of turned coordinates are noise, and 6e-17 would stand for 0.
pub fn number(x: f64) -> String {
    let rounded = format!("{x:.11e}").parse::<f64>().unwrap_or(x);
    let rounded = if rounded.abs() < 1e-14 { 0.0 } else { rounded };
    format!("{rounded}")
}

/// Numbers in brackets.
pub fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    let words: Vec<String> = numbers.into_iter().map(number).collect();
    format!("[{}]", words.join(", "))
}

/// A text in quotes.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' | '\\' => out.extend(['\\', c]),
            c if c.is_control() => out += &format!("\\u{:04x}", c as u32),
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

/// A key of a table: bare where it can be.
pub fn key(name: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(bare) { name.to_string() } else { quoted(name) }
}

/// A spectrum.
pub fn spectrum(s: &Spectrum) -> String {
    match s {
        Spectrum::Constant(c) => number(*c),
        Spectrum::Table(points) => {
            let short = |x: f64| number(format!("{x:.8e}").parse().unwrap_or(x));
            let words: Vec<String> = points.iter().map(|(nm, v)| format!("[{}, {}]", short(*nm), short(*v))).collect();
            format!("[{}]", words.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn toml_reads_them_back() {
        assert_eq!([0.1 + 0.2, 6e-17, -0.0, 7.166e6, 1e-9].map(number), ["0.3", "0", "0", "7166000", "0.000000001"]);
        for text in ["a.b", "it's \"so\"", "back\\slash", "new\nline", ""] {
            let table: toml::Table = format!("{} = {}", key(text), quoted(text)).parse().unwrap();
            assert_eq!(table[text].as_str(), Some(text));
        }
        assert_eq!(
            spectrum(&Spectrum::Table(vec![(400.0, 0.5), (700.0, 1.0 / 3.0)])),
            "[[400, 0.5], [700, 0.333333333]]"
        );
    }
}
