//! Colour by night: under 5.62e-3 cd/m2 rods see alone, in shades of grey; over 5.62 cd/m2 cones do [Ward 1997, section 4.4].
//!
//! ```text
//! w = clip((Y - 0.00562) / (5.62 - 0.00562), 0, 1)
//! seen = w colour + (1 - w) grey(V / 2.26)
//! ```
//!
//! V is the scotopic luminance, 1700 lm/W by V'(lambda); 2.26 that of a white of 1 cd/m2, so that white keeps its brightness
//! and blue gains over red (Purkinje's shift). Where no spectrum is left, V is estimated from the unadapted tristimulus values
//! [Ward 1997]: V = Y (1.33 (1 + (Y + Z) / X) - 1.68).

/// Rods see alone up to here, cd/m2.
pub const RODS_ONLY_CD_M2: f32 = 5.62e-3;
/// Cones see alone from here, cd/m2.
pub const CONES_ONLY_CD_M2: f32 = 5.62;
/// Scotopic luminance of a white of 1 cd/m2.
pub const WHITE_SCOTOPIC: f32 = 2.26;
/// Lumens a watt of scotopic luminance at the peak of V'(lambda).
pub const SCOTOPIC_EFFICACY: f64 = 1700.0;

/// Largest ratio of scotopic to photopic luminance that the estimate may give: pure blue has 7.2, monochromatic violet 20.
const LARGEST_RATIO: f32 = 30.0;

/// Share of what cones see, 0 to 1.
///
/// ```
/// use luxpipe::tone::mesopic::cone_share;
/// assert!((cone_share(1.0) - 0.1771131).abs() < 1e-6 && cone_share(1e-4) == 0.0 && cone_share(10.0) == 1.0);
/// ```
#[inline(always)]
pub fn cone_share(luminance_cd_m2: f32) -> f32 {
    let w = (luminance_cd_m2 - RODS_ONLY_CD_M2) / (CONES_ONLY_CD_M2 - RODS_ONLY_CD_M2);
    w.clamp(0.0, 1.0)
}

/// Scotopic luminance estimated from XYZ as the eye received it; 0 and up, finite where XYZ is.
///
/// ```
/// use luxpipe::tone::mesopic::scotopic;
/// assert!((scotopic([0.95047, 1.0, 1.08883]) - 2.572916).abs() < 1e-5); // D65
/// assert!((scotopic([1.0985, 1.0, 0.35585]) - 1.291584).abs() < 1e-5); // A
/// assert!(scotopic([0.0, 1.0, 1.0]).is_finite());
/// ```
#[inline(always)]
pub fn scotopic([x, y, z]: [f32; 3]) -> f32 {
    // The ratio grows without end as X goes to 0, which no light has with Y above 0.
    let ratio = 1.33 * (1.0 + (y + z) / x.max(1e-3 * (y + z).max(f32::MIN_POSITIVE))) - 1.68;
    y.max(0.0) * ratio.clamp(0.0, LARGEST_RATIO)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_estimate_is_the_published_one() {
        // The rows of the mesopic case, by an independent evaluation of the formula.
        for (xyz, want) in [
            ([1.0, 1.0, 1.0], 2.31),
            ([0.4124, 0.2126, 0.0193], 0.08458995),
            ([0.1805, 0.0722, 0.9505], 0.5188064),
            ([0.3576, 0.7152, 0.1192], 1.969184),
        ] {
            assert!((scotopic(xyz) - want).abs() < 1e-5, "{xyz:?}");
        }
        for xyz in [[0.0; 3], [1e-40, 1.0, 0.0], [1.0, 1e-3, 0.0], [-1.0, 1.0, 1.0], [1.0, -1.0, 1.0]] {
            let v = scotopic(xyz);
            assert!(v >= 0.0 && v.is_finite(), "{xyz:?} {v}");
        }
    }

    #[test]
    fn colour_fades_without_a_step() {
        let mut last = cone_share(0.0);
        for i in 0..4000 {
            let w = cone_share(10f32.powf(-4.0 + i as f32 * 0.0015));
            assert!(w >= last && w - last < 4e-3);
            last = w;
        }
    }
}
