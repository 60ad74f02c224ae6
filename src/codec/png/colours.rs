//! Which colours the codes of a file are.

use png::Info;

use crate::codec::png::icc::{self, Curve};
use crate::codec::png::{UNSPECIFIED, h273_primaries};
use crate::color::Primaries;
use crate::stream::meaning::Overrides;
use crate::{Error, Result};

/// Which colours the codes are.
pub struct Colours {
    /// Primaries and white.
    pub primaries: Primaries,
    /// Codes to light.
    pub curves: Curves,
}

/// Codes to light.
pub enum Curves {
    /// Red, green and blue alone.
    Alone([Curve; 3]),
    /// SMPTE ST 2084.
    Pq,
    /// Hybrid log-gamma.
    Hlg,
}

impl Colours {
    fn new(primaries: Primaries, curve: Curve) -> Colours {
        Colours { primaries, curves: Curves::Alone([curve.clone(), curve.clone(), curve]) }
    }
}

/// By the first of cICP, iCCP, sRGB, gAMA and cHRM that is there and understood.
pub fn colours(info: &Info, overrides: &Overrides, note: &dyn Fn(&str)) -> Result<Colours> {
    let primaries = info.chrm_chunk.and_then(|c| {
        let xy = [c.red, c.green, c.blue, c.white].map(|(x, y)| [x, y].map(|n| f64::from(n.into_scaled()) / 1e5));
        Primaries::from_numbers(xy.as_flattened())
    });
    if let Some(code) = &info.coding_independent_code_points {
        if !code.is_video_full_range_image {
            return Err(Error::Unsupported("cICP says narrow range; expected full range".into()));
        }
        let unspecified = code.color_primaries == UNSPECIFIED;
        let said = if unspecified { primaries } else { h273_primaries(code.color_primaries) };
        match (said, h273_curve(code.transfer_function)) {
            (Some(primaries), Some(curves)) => {
                if let Curves::Alone([Curve::Gamma(2.4), ..]) = curves {
                    note("cICP names a camera's curve: taking that of a BT.1886 display, gamma 2.4");
                }
                return Ok(Colours { primaries, curves });
            }
            _ => note(&format!(
                "cICP {}/{} is not known here: what else the file says of its colours counts",
                code.color_primaries, code.transfer_function
            )),
        }
    }
    if let Some(profile) = &info.icc_profile {
        match icc::read(profile) {
            Ok(p) => return Ok(Colours { primaries: p.primaries, curves: Curves::Alone(p.curves) }),
            Err(what) => note(&format!(
                "its ICC profile {what}: what else the file says counts; expected RGB by matrix and curves"
            )),
        }
    }
    if info.srgb.is_some() {
        return Ok(Colours::new(Primaries::BT709, Curve::Srgb));
    }
    let gamma = info.gama_chunk.map(|g| 1e5 / f64::from(g.into_scaled())).filter(|g| (0.1..=10.0).contains(g));
    if gamma.is_none() && primaries.is_none() {
        let curve = if overrides.primaries.is_some() { "its curve" } else { "its colours" };
        note(&format!("the file says nothing of {curve}: taking sRGB"));
    }
    Ok(Colours::new(primaries.unwrap_or(Primaries::BT709), gamma.map_or(Curve::Srgb, Curve::Gamma)))
}

/// Transfer characteristics of H.273, as a display decodes them.
fn h273_curve(code: u8) -> Option<Curves> {
    let alone = |c: Curve| Some(Curves::Alone([c.clone(), c.clone(), c]));
    match code {
        1 | 6 | 14 | 15 => alone(Curve::Gamma(2.4)),
        4 => alone(Curve::Gamma(2.2)),
        5 => alone(Curve::Gamma(2.8)),
        8 => alone(Curve::Gamma(1.0)),
        13 => alone(Curve::Srgb),
        16 => Some(Curves::Pq),
        18 => Some(Curves::Hlg),
        _ => None,
    }
}
