//! Glare indices: one number for how much all sources together disturb, or keep from seeing.

use crate::glare::Ray;
use crate::glare::sources::Source;
use crate::statistics::normal_cdf;

/// What the indices are made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Illuminance at the eye, on a plane across the line of sight, Ev, lux.
    pub illuminance_lux: f64,
    /// The sources' part of it, lux.
    pub direct_lux: f64,
    /// Mean luminance of the field, cd/m2.
    pub mean_cd_m2: f64,
    /// Luminance of the background, Lb, cd/m2.
    pub background_cd_m2: f64,
}

/// A glare source as the formulas have it: luminance L, solid angle w, position index P.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// cd/m2
    pub luminance_cd_m2: f64,
    /// sr
    pub solid_angle_sr: f64,
    /// From 1.
    pub position_index: f64,
}

impl From<&Source> for Light {
    fn from(source: &Source) -> Light {
        Light {
            luminance_cd_m2: source.sums.mean(),
            solid_angle_sr: source.sums.solid_angle_sr,
            position_index: source.position_index(),
        }
    }
}

/// Sum of L^2 w / P^2.
fn squares(lights: &[Light]) -> f64 {
    lights.iter().map(|s| s.luminance_cd_m2.powi(2) * s.solid_angle_sr / s.position_index.powi(2)).sum()
}

/// A logarithm to base 10, scaled; 0 of what is not above 0: a scene without glare, as evalglare has it.
fn scaled_log(scale: f64, x: f64) -> f64 {
    if x > 0.0 && x.is_finite() { scale * x.log10() } else { 0.0 }
}

/// Daylight glare probability [Wienold 2006], at most 1:
/// 5.87e-5 Ev + 0.0918 lg(1 + sum L^2 w / (Ev^1.87 P^2)) + 0.16.
///
/// ```
/// use luxpipe::glare::indices::{Light, Scene, dgp};
/// let scene = Scene { illuminance_lux: 1000.0, direct_lux: 0.0, mean_cd_m2: 0.0, background_cd_m2: 0.0 };
/// assert!((dgp(&scene, &[]) - 0.2187).abs() < 1e-9);
/// // 1e8 x 0.01 / 10^5.61 = 2.4547, lg 3.4547 = 0.53841
/// let light = Light { luminance_cd_m2: 1e4, solid_angle_sr: 0.01, position_index: 1.0 };
/// assert!((dgp(&scene, &[light]) - 0.2187 - 0.0918 * 0.53841).abs() < 1e-6);
/// ```
pub fn dgp(scene: &Scene, lights: &[Light]) -> f64 {
    let ratio = squares(lights) / scene.illuminance_lux.powf(1.87);
    let contrast = if ratio.is_finite() { (1.0 + ratio).log10() } else { 0.0 };
    (5.87e-5 * scene.illuminance_lux + 0.0918 * contrast + 0.16).min(1.0)
}

/// Factor that takes the probability down in low light, where it was never measured [Wienold 2010]:
/// exp(0.024 Ev - 4) / (1 + exp(0.024 Ev - 4)). evalglare 3.06 applies it below 1000 lux, and only with `-C l+`.
///
/// ```
/// let factor = luxpipe::glare::indices::low_light(4.0 / 0.024);
/// assert!((factor - 0.5).abs() < 1e-12);
/// ```
pub fn low_light(illuminance_lux: f64) -> f64 {
    if illuminance_lux >= 1000.0 { 1.0 } else { 1.0 / (1.0 + (4.0 - 0.024 * illuminance_lux).exp()) }
}

/// Daylight glare index [Hopkinson 1972; Chauvel 1982]: 10 lg sum 0.478 L^1.6 W^0.8 / (Lb + 0.07 w^0.5 L), W = w / P^2.
pub fn dgi(scene: &Scene, lights: &[Light]) -> f64 {
    let term = |s: &Light| {
        let weighted = s.solid_angle_sr / s.position_index.powi(2);
        let below = scene.background_cd_m2 + 0.07 * s.solid_angle_sr.sqrt() * s.luminance_cd_m2;
        0.478 * s.luminance_cd_m2.powf(1.6) * weighted.powf(0.8) / below
    };
    scaled_log(10.0, lights.iter().map(term).sum())
}

/// Unified glare rating [CIE 117]: 8 lg (0.25 / Lb sum L^2 w / P^2).
///
/// ```
/// use luxpipe::glare::indices::{Light, Scene, ugr};
/// let scene = Scene { illuminance_lux: 0.0, direct_lux: 0.0, mean_cd_m2: 0.0, background_cd_m2: 25.0 };
/// let light = Light { luminance_cd_m2: 1e4, solid_angle_sr: 0.01, position_index: 1.0 };
/// assert!((ugr(&scene, &[light]) - 32.0).abs() < 1e-9); // 0.01 x 1e6 = 1e4
/// ```
pub fn ugr(scene: &Scene, lights: &[Light]) -> f64 {
    scaled_log(8.0, 0.25 / scene.background_cd_m2 * squares(lights))
}

/// Unified glare probability [Hirning 2014]: 0.26 lg (0.25 / Lb sum L^2 w / P^2).
pub fn ugp(scene: &Scene, lights: &[Light]) -> f64 {
    ugr(scene, lights) * 0.26 / 8.0
}

/// Unified glare probability in its second form [Hirning 2017]: (1 + 2/7 (sum L^2 w / (Lb P^2))^(-1/5))^(-10).
pub fn ugp2(scene: &Scene, lights: &[Light]) -> f64 {
    let x = squares(lights) / scene.background_cd_m2;
    if x > 0.0 && x.is_finite() { (1.0 + 2.0 / 7.0 * x.powf(-0.2)).powi(-10) } else { 0.0 }
}

/// CIE glare index [Einhorn 1979]: 8 lg (2 (1 + Ed / 500) / Ev sum L^2 w / P^2).
pub fn cgi(scene: &Scene, lights: &[Light]) -> f64 {
    scaled_log(8.0, 2.0 * (1.0 + scene.direct_lux / 500.0) / scene.illuminance_lux * squares(lights))
}

/// Discomfort glare rating [IES 1966]: (sum 0.5 L Q / (P F^0.44))^(n^-0.0914), Q = 20.4 w + 1.52 w^0.2 - 0.075, F the mean
/// luminance of the field.
pub fn dgr(scene: &Scene, lights: &[Light]) -> f64 {
    let term = |s: &Light| {
        let w = s.solid_angle_sr;
        let q = (20.4 * w + 1.52 * w.powf(0.2) - 0.075).max(0.0);
        0.5 * s.luminance_cd_m2 * q / (s.position_index * scene.mean_cd_m2.powf(0.44))
    };
    let sum: f64 = lights.iter().map(term).sum();
    if sum > 0.0 && sum.is_finite() { sum.powf((lights.len() as f64).powf(-0.0914)) } else { 0.0 }
}

/// Visual comfort probability in percent: the share of people who accept it [IES 1966], the normal distribution at
/// 6.374 - 1.3227 ln DGR; 100 below a rating of 20 and 0 above 750, where its chart ends.
///
/// ```
/// use luxpipe::glare::indices::vcp;
/// assert!((vcp(6.374f64.exp().powf(1.0 / 1.3227)) - 50.0).abs() < 1e-4);
/// assert_eq!((vcp(10.0), vcp(800.0)), (100.0, 0.0));
/// ```
pub fn vcp(dgr: f64) -> f64 {
    match dgr {
        _ if dgr < 20.0 => 100.0,
        _ if dgr > 750.0 => 0.0,
        _ => 100.0 * normal_cdf(6.374 - 1.3227 * dgr.ln()),
    }
}

/// Threshold increment in percent [CIE 140]: how much more contrast a thing needs to be seen through the veil.
/// 65 Lv / Lb^0.8 up to a background of 5 cd/m2, 95 Lv / Lb^1.05 above.
pub fn threshold_increment(veiling_cd_m2: f64, background_cd_m2: f64) -> Option<f64> {
    let (factor, power) = if background_cd_m2 <= 5.0 { (65.0, 0.8) } else { (95.0, 1.05) };
    (background_cd_m2 > 0.0).then(|| factor * veiling_cd_m2 / background_cd_m2.powf(power))
}

/// Formula of the veil that light scattered in the eye lays over the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Veil {
    /// Stiles and Holladay's with age, for angles from 1 degree.
    StilesHolladay,
    /// The CIE's general equation, for angles from 0.1 degree.
    Cie,
}

/// Veiling luminance of one pixel [CIE 146; Vos 2003], E the illuminance it gives at the eye, t its angle in degrees, A the age
/// in years:
///
/// - Stiles-Holladay: 10 E / t^2 (1 + (A/70)^4); nearer than 1 degree counts as 1.
/// - CIE general: E (10 / t^3 + (5 / t^2 + 0.1 p / t) (1 + (A/62.5)^4) + 0.0025 p); nearer than 0.1 counts as 0.1; the eye's
///   pigment p from 0 (black) over 0.5 (brown) to 1.2 (light blue).
///
/// ```
/// use luxpipe::glare::{Ray, indices::{Veil, veiling_cd_m2}};
/// let cos = 10f64.to_radians().cos(); // 1 lux at 10 degrees
/// let ray = Ray { direction: [10f64.to_radians().sin(), 0.0, cos], solid_angle_sr: 0.001, luminance: 1000.0 / cos };
/// assert!((veiling_cd_m2(&ray, Veil::StilesHolladay, 70.0, 0.5) - 0.2).abs() < 1e-9);
/// assert!((veiling_cd_m2(&ray, Veil::Cie, 0.0, 0.5) - (0.01 + 0.05 + 0.005 + 0.00125)).abs() < 1e-9);
/// ```
pub fn veiling_cd_m2(ray: &Ray, veil: Veil, age_years: f64, pigment: f64) -> f64 {
    let [x, y, z] = ray.direction;
    let t = x.hypot(y).atan2(z).to_degrees();
    let per_lux = match veil {
        Veil::StilesHolladay => 10.0 / t.max(1.0).powi(2) * (1.0 + (age_years / 70.0).powi(4)),
        Veil::Cie => {
            let t = t.max(0.1);
            let aged = (5.0 / (t * t) + 0.1 * pigment / t) * (1.0 + (age_years / 62.5).powi(4));
            10.0 / t.powi(3) + aged + 0.0025 * pigment
        }
    };
    ray.illuminance_lux() * per_lux
}
