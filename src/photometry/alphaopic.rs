//! Alpha-opic quantities [CIE S 026]: how much light excites each of the eye's five receptors, and the daylight that would
//! excite it as much.
//!
//! E_a = integral of E(w) s_a(w) dw, W/m2, with E the spectral irradiance and s_a the receptor's action spectrum, 1 at its
//! peak. Over the illuminance it is the alpha-opic efficacy of luminous radiation (ELR, W/lm); E_a over the ELR of D65 is
//! the equivalent daylight illuminance (EDI, lux); ELR over that of D65 the daylight efficacy ratio (DER). All hold for
//! radiance and luminance alike.
//!
//! The spectra are those of a standard observer of 32 years and a field of 10 degrees for the cones; they say nothing of what
//! the excitation does: CIE S 026 leaves that open.

use crate::Result;
use crate::spectral::{Spectrum, builtin};
use crate::units::K_M;

/// The five receptors, in the order of every array here.
pub const RECEPTORS: [&str; 5] = ["s_cone", "m_cone", "l_cone", "rhodopic", "melanopic"];

/// The action spectra, V(lambda), and D65's efficacies.
#[derive(Clone, Debug)]
pub struct AlphaOpic {
    action: [Spectrum; 5],
    photopic: Spectrum,
    d65_elr: [f64; 5],
}

/// What one light amounts to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quantities {
    /// Illuminance, lux (luminance in cd/m2 for a spectral radiance).
    pub illuminance: f64,
    /// Alpha-opic irradiance, mW/m2 (radiance in mW/sr/m2).
    pub irradiance_mw_m2: [f64; 5],
    /// Efficacy of luminous radiation, mW/lm; 0 for no light.
    pub elr_mw_lm: [f64; 5],
    /// Equivalent daylight (D65) illuminance, lux.
    pub edi_lux: [f64; 5],
    /// Daylight (D65) efficacy ratio; 0 for no light.
    pub der: [f64; 5],
}

impl AlphaOpic {
    /// From the tables of spectra/.
    pub fn new() -> Result<AlphaOpic> {
        let action = |name: &str| builtin::spectrum(&format!("alphaopic_{name}"));
        let [s, m, l, rhodopic, melanopic] = RECEPTORS.map(action);
        let photopic = builtin::spectrum("photopic_v")?;
        let mut all = AlphaOpic { action: [s?, m?, l?, rhodopic?, melanopic?], photopic, d65_elr: [1.0; 5] };
        all.d65_elr = all.quantities(&builtin::spectrum("illuminant_D65")?).elr_mw_lm;
        Ok(all)
    }

    /// The action spectra.
    pub fn action(&self) -> &[Spectrum; 5] {
        &self.action
    }

    /// The five efficacies of D65, mW/lm.
    pub fn d65_elr_mw_lm(&self) -> [f64; 5] {
        self.d65_elr
    }

    /// The quantities of a spectral irradiance in W/m2/nm.
    ///
    /// ```
    /// use luxpipe::photometry::alphaopic::AlphaOpic;
    /// use luxpipe::spectral::builtin;
    /// let a = AlphaOpic::new().unwrap().quantities(&builtin::spectrum("A").unwrap());
    /// assert!((a.der[4] - 0.496).abs() < 1e-3); // melanopic, of incandescent light
    /// ```
    pub fn quantities(&self, irradiance: &Spectrum) -> Quantities {
        let weighted = |s: &Spectrum| s.product_integral(irradiance, 0.0, f64::INFINITY);
        let energies = self.action.each_ref().map(|s| 1000.0 * weighted(s));
        self.of_sums(K_M * weighted(&self.photopic), energies)
    }

    /// The quantities of an illuminance in lux and the five alpha-opic irradiances in mW/m2, wherever they come from.
    pub fn of_sums(&self, illuminance: f64, irradiance_mw_m2: [f64; 5]) -> Quantities {
        let elr = irradiance_mw_m2.map(|e| if illuminance > 0.0 { e / illuminance } else { 0.0 });
        let over_daylight = |v: [f64; 5]| std::array::from_fn(|i| v[i] / self.d65_elr[i]);
        Quantities {
            illuminance,
            irradiance_mw_m2,
            elr_mw_lm: elr,
            edi_lux: over_daylight(irradiance_mw_m2),
            der: over_daylight(elr),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// CIE S 026, Table 3: efficacies of D65 in mW/lm, in the order S, M, L, rhodopic, melanopic.
    #[test]
    fn efficacies_of_d65() {
        let got = AlphaOpic::new().unwrap().d65_elr_mw_lm();
        for (got, want) in got.into_iter().zip([0.8173, 1.4558, 1.6289, 1.4497, 1.3262]) {
            assert!((got - want).abs() < 1e-4, "{got} {want}");
        }
    }

    #[test]
    fn daylight_is_its_own_equivalent() {
        let all = AlphaOpic::new().unwrap();
        let d65 = builtin::spectrum("D65").unwrap();
        let lux = all.quantities(&d65).illuminance;
        let q = all.quantities(&d65.scaled(1000.0 / lux));
        assert!((q.illuminance - 1000.0).abs() < 1e-9);
        assert!(
            q.edi_lux.iter().all(|edi| (edi - 1000.0).abs() < 1e-9) && q.der.iter().all(|d| (d - 1.0).abs() < 1e-12)
        );
        assert!((q.irradiance_mw_m2[4] - 1326.2).abs() < 0.1);
    }

    /// Daylight efficacy ratios by luxpy 1.12.5, an independent program: `photbiochem.spd_to_aopicDER` of these illuminants,
    /// linear to 1 nm from 380 to 780.
    const DER: [(&str, [f64; 5]); 4] = [
        ("A", [0.31097, 0.80655, 1.0171, 0.57303, 0.49575]),
        ("FL11", [0.59132, 0.86991, 0.99103, 0.64792, 0.56360]),
        ("LED-B3", [0.61764, 0.88412, 0.99776, 0.69854, 0.63257]),
        ("D50", [0.74688, 0.94995, 1.0003, 0.87630, 0.84736]),
    ];

    #[test]
    fn ratios_of_other_lamps() {
        let all = AlphaOpic::new().unwrap();
        for (lamp, want) in DER {
            let q = all.quantities(&builtin::spectrum(lamp).unwrap());
            for (got, want) in q.der.into_iter().zip(want) {
                assert!((got - want).abs() < 1e-3, "{lamp}: {:?} {want:?}", q.der);
            }
        }
    }

    #[test]
    fn darkness_and_single_lines() {
        let all = AlphaOpic::new().unwrap();
        let dark = all.quantities(&Spectrum::Constant(0.0));
        assert_eq!((dark.illuminance, dark.edi_lux, dark.der), (0.0, [0.0; 5], [0.0; 5]));
        // A narrow line at 490 nm, 1 W/m2: the melanopic action spectrum is 1 there within 1e-4 of its peak.
        let line = Spectrum::from_points(vec![(489.0, 0.0), (490.0, 1.0), (491.0, 0.0)]).unwrap();
        let q = all.quantities(&line);
        assert!((q.irradiance_mw_m2[4] - 1000.0).abs() < 1.0, "{}", q.irradiance_mw_m2[4]);
    }
}
