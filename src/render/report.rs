//! What lighting practice asks of a point: illuminance, colour temperature, what the eye's five receptors get, daylight.

use crate::Result;
use crate::color::Xy;
use crate::photometry::alphaopic::AlphaOpic;
use crate::photometry::cct::Locus;
use crate::scene::Scene;

/// Turns [`crate::render::estimate::What::Lighting`] into columns.
pub struct Report {
    locus: Locus,
    alphaopic: AlphaOpic,
    daylight_lux: Option<f64>,
}

impl Report {
    /// Names of the columns.
    pub const COLUMNS: &'static str =
        "lux\tcct_k\tduv\tedi_s_cone\tedi_m_cone\tedi_l_cone\tedi_rhodopic\tedi_melanopic\tdaylight_factor_percent";

    /// Of a scene, whose sky in the open is what daylight factors are of.
    pub fn new(scene: &Scene) -> Result<Report> {
        Ok(Report { locus: Locus::new()?, alphaopic: AlphaOpic::new()?, daylight_lux: scene.daylight_lux()? })
    }

    /// One row: XYZ in lx and five alpha-opic irradiances in W/m2 to the columns. No light has no colour, a light far from
    /// all blackbodies no colour temperature, and a room with lamps no daylight factor: they are NaN.
    pub fn row(&self, values: &[f32]) -> Vec<f64> {
        let value = |i: usize| f64::from(values[i]);
        let lux = value(1);
        let near = Xy::of([value(0), lux, value(2)]).map(|xy| self.locus.nearest(xy));
        let cct = near.filter(|c| c.is_meaningful()).map_or(f64::NAN, |c| c.kelvin);
        let duv = near.map_or(f64::NAN, |c| c.duv);
        let opic = self.alphaopic.of_sums(lux, std::array::from_fn(|i| 1000.0 * value(3 + i)));
        let factor = self.daylight_lux.map_or(f64::NAN, |open| 100.0 * lux / open);
        [&[lux, cct, duv][..], &opic.edi_lux, &[factor]].concat()
    }
}
