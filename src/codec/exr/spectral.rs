//! Names of spectral channels: `S0.550,000000nm` is the radiance at 550 nm, `S1` to `S3` the rest of its Stokes vector.

use crate::color::Xy;
use crate::error::printable;
use crate::spectral::Sampling;
use crate::stream::meaning::MOST_COMPONENTS;
use crate::stream::{Components, Header};
use crate::{Error, Result, invalid};

/// Metres a second.
const LIGHT: f64 = 299_792_458.0;

/// Multiples and parts of units, with the power of ten.
const PREFIXES: [(&str, i32); 16] = [
    ("da", 1),
    ("Y", 24),
    ("Z", 21),
    ("E", 18),
    ("P", 15),
    ("T", 12),
    ("G", 9),
    ("M", 6),
    ("k", 3),
    ("h", 2),
    ("d", -1),
    ("c", -2),
    ("m", -3),
    ("u", -6),
    ("n", -9),
    ("p", -12),
];

/// A channel's Stokes component and wavelength in nm; `None` for one of another kind.
pub(super) fn parse(name: &str) -> Option<Result<(usize, f64)>> {
    let rest = name.strip_prefix('S')?;
    let (digit, rest) = rest.split_at_checked(1)?;
    let stokes = digit.parse::<usize>().ok().filter(|n| *n < 4)?;
    let value = rest.strip_prefix('.')?;
    let wrong = || {
        let name = printable(name.as_bytes());
        Error::Invalid(format!("channel {name}: expected a wavelength such as S0.550,000000nm, or a frequency in Hz"))
    };
    Some(wavelength(value).ok_or_else(wrong).map(|nm| (stokes, nm)))
}

fn wavelength(text: &str) -> Option<f64> {
    let (text, hertz) = match text.strip_suffix("Hz") {
        Some(text) => (text, true),
        None => (text.strip_suffix('m')?, false),
    };
    // A power of ten ends in a digit, so what is left of letters at the end is the prefix.
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match &text[digits.len()..] {
        "" => 0,
        prefix => PREFIXES.iter().find(|(p, _)| *p == prefix)?.1,
    };
    let number: f64 = digits.replace(',', ".").parse().ok()?;
    // By whole powers of ten, so that 550,0nm is 550 and not its neighbour.
    let ten = |power: i32| if power < 0 { 1.0 / 10f64.powi(-power) } else { 10f64.powi(power) };
    let nm = if hertz { LIGHT * 1e9 / (number * ten(power)) } else { number * ten(power + 9) };
    (nm.is_finite() && nm > 0.0).then_some(nm)
}

/// The name of each component's channel, in the order of components.
pub(super) fn names(header: &Header) -> Result<Vec<String>> {
    let sampling = header.sampling.as_ref().ok_or_else(|| Error::Invalid("the picture lists no wavelengths".into()))?;
    let vectors = if header.components == Components::Stokes { 4 } else { 1 };
    let name = |k: usize| {
        let nm = format!("{:.6}", sampling.centre_nm(k / vectors)).replace('.', ",");
        format!("S{}.{nm}nm", k % vectors)
    };
    let names: Vec<String> = (0..header.ncomp).map(name).collect();
    let mut sorted = names.clone();
    sorted.sort();
    match sorted.windows(2).find(|w| w[0] == w[1]) {
        Some(pair) => invalid!("two wavelengths share the name {}: they must differ by 1e-6 nm or more", pair[0]),
        None => Ok(names),
    }
}

/// A spectral picture found among channels.
pub(super) struct Found {
    pub sampling: Sampling,
    pub components: Components,
    /// The channel of each component.
    pub channels: Vec<usize>,
}

/// Looks for spectral radiance among the channels' names. `stated` gives the exact sampling that a text of ours keeps,
/// if it has one for so many wavelengths.
pub(super) fn find<'a>(
    names: impl Iterator<Item = &'a str>,
    stated: impl FnOnce(usize) -> Option<Sampling>,
) -> Result<Option<Found>> {
    let mut vectors: [Vec<(f64, usize)>; 4] = Default::default();
    for (index, name) in names.enumerate() {
        if let Some(channel) = parse(name) {
            let (stokes, nm) = channel?;
            vectors[stokes].push((nm, index));
        }
    }
    vectors.iter_mut().for_each(|v| v.sort_by(|a, b| a.0.total_cmp(&b.0)));
    let count = vectors[0].len();
    if count == 0 {
        return Ok(None);
    }
    let same = |v: &Vec<(f64, usize)>| v.len() == count && v.iter().zip(&vectors[0]).all(|(a, b)| a.0 == b.0);
    let whole = vectors[1..].iter().all(same);
    let (components, stride) = if whole { (Components::Stokes, 4) } else { (Components::Spectrum, 1) };
    if count * stride > MOST_COMPONENTS {
        return invalid!("{} spectral channels; at most {MOST_COMPONENTS} are read", count * stride);
    }
    let (sampling, descends) = match stated(count).and_then(|s| agrees(&s, &vectors[0]).map(|d| (s, d))) {
        Some(stated) => stated,
        None => (Sampling::points(vectors[0].iter().map(|c| c.0).collect())?, false),
    };
    let mut channels = Vec::with_capacity(count * stride);
    for k in 0..count {
        let k = if descends { count - 1 - k } else { k };
        channels.extend(vectors[..stride].iter().map(|v| v[k].1));
    }
    Ok(Some(Found { sampling, components, channels }))
}

/// Whether a sampling has these ascending wavelengths, to the digits of a name: true if in descending order.
fn agrees(sampling: &Sampling, ascending: &[(f64, usize)]) -> Option<bool> {
    let n = sampling.count();
    let descends = n > 1 && sampling.centre_nm(0) > sampling.centre_nm(n - 1);
    let at = |k: usize| sampling.centre_nm(if descends { n - 1 - k } else { k });
    (0..n).all(|k| (at(k) - ascending[k].0).abs() < 1e-5).then_some(descends)
}

/// A number as it was meant when it was rounded to a float of 32 bits: the shortest that gives that float.
pub(super) fn plain(x: f32) -> f64 {
    format!("{x}").parse().unwrap_or(f64::from(x))
}

/// A chromaticity from two floats, if it is one.
pub(super) fn xy(n: [f32; 2]) -> Option<Xy> {
    let xy = Xy { x: plain(n[0]), y: plain(n[1]) };
    xy.is_physical().then_some(xy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Names of the layout's paper and of other units.
    #[test]
    fn wavelengths_in_every_unit() {
        let nm = |name: &str| parse(name).map(|r| r.map(|(s, nm)| (s, (nm * 1e6).round() / 1e6)).ok());
        assert_eq!(nm("S0.550,000000nm"), Some(Some((0, 550.0))));
        assert_eq!(nm("S3.5,5E2nm"), Some(Some((3, 550.0))));
        assert_eq!(nm("S1.0,55um"), Some(Some((1, 550.0))));
        assert_eq!(nm("S0.5e-7m"), Some(Some((0, 500.0))));
        assert_eq!(nm("S2.599,584916THz"), Some(Some((2, 500.0))));
        assert_eq!(nm("S0.550"), Some(None));
        assert_eq!(nm("S0.xnm"), Some(None));
        assert_eq!(nm("S0.0nm"), Some(None));
        assert_eq!((nm("S4.550nm"), nm("T.550nm"), nm("S"), nm("R")), (None, None, None, None));
    }
}
