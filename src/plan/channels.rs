//! Three channels in place of wavelengths: what renderers of RGB carry, and the relative colours of [Ward 2001, "Relative Color
//! Approximation"] among them.
//!
//! A channel is what a spectrum is in the mean under a light, seen by one sensor of an RGB space: linear in the spectrum, 1 of what is
//! white. Paths carry three of them as if they were wavelengths, and each light's matrix makes XYZ of what arrives. Metals get the index
//! whose reflectance at normal incidence is the channel's. What lies outside the space's gamut would be below 0 and counts as 0.

use std::fmt;
use std::str::FromStr;

use crate::color::{Cat, Mat3, Primaries, Xy, adapt};
use crate::material::Ink;
use crate::optics::fresnel;
use crate::plan::survey::{BINS, Lit, Survey, fine};
use crate::render::few::{Converted, Few};
use crate::scene::Scene;
use crate::spectral::{Rule, Spectrum, builtin};
use crate::{Error, Result, invalid};

/// Wavelengths that channels stand at: blue, green, red, nm. Any three would do.
pub const AT_NM: [f64; 3] = [450.0, 550.0, 650.0];
/// Of the sensor of a light to a channel, over the light's Y: below it quotients are noise.
const SMALLEST: f64 = 1e-3;

/// How a scene is put into three channels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
    /// Relative colours: materials in BT.2020 as the dominant light shows them, over that light.
    Relative,
    /// The same by the paper's wording: absolute BT.709 colours under the dominant light, which is white.
    Literal,
    /// Materials by D65 in BT.709, lights with their own BT.709 colours.
    Product,
    /// The same, all lights white; the picture gets the dominant light's colour by adaptation.
    White,
}

/// All of them with their names.
pub const ALL: [(&str, Channels); 4] = [
    ("relative", Channels::Relative),
    ("literal", Channels::Literal),
    ("product", Channels::Product),
    ("white", Channels::White),
];

impl fmt::Display for Channels {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        ALL.iter().find(|c| c.1 == *self).map_or(Ok(()), |c| f.write_str(c.0))
    }
}

impl FromStr for Channels {
    type Err = Error;

    fn from_str(s: &str) -> Result<Channels> {
        let names: Vec<&str> = ALL.iter().map(|c| c.0).collect();
        let found = ALL.iter().find(|c| c.0 == s).map(|c| c.1);
        found.ok_or_else(|| Error::Invalid(format!("'{s}' is none of {}", names.join(", "))))
    }
}

/// What turns spectra into channels, and lights' channels into XYZ.
#[derive(Clone, Debug)]
pub struct Converter {
    /// [channel, long wavelengths last][bin]: sums to 1.
    sensors: [Vec<f64>; 3],
    /// What a white surface is: 1, but for literal colours.
    white: [f64; 3],
    /// Weights of lights of Y = 100.
    rule: Rule,
}

impl Converter {
    /// For the lights of a scene.
    ///
    /// # Errors
    /// A dominant light that the space can hardly make.
    pub fn new(channels: Channels, survey: &Survey) -> Result<Converter> {
        let dominant = &survey.lights[survey.dominant];
        let space = if channels == Channels::Relative { Primaries::BT2020 } else { Primaries::BT709 };
        let matrices = (space.from_xyz(), space.to_xyz());
        let (Some(from_xyz), Some(to_xyz)) = matrices else { return invalid!("a space without area") };
        let relative = matches!(channels, Channels::Relative | Channels::Literal);
        let daylight;
        let by = match relative {
            true => dominant,
            false => {
                daylight = Lit::of(&builtin::spectrum("illuminant_D65")?)?;
                &daylight
            }
        };
        let sensed = |light: &Lit| -> [f64; 3] { from_xyz.apply(light.xyz()) };
        let shown = sensed(by);
        if let Some(small) = shown.iter().find(|c| c.is_nan() || **c <= 100.0 * SMALLEST) {
            return invalid!("the light that materials are seen by has a component of {:.4} in {space}", small / 100.0);
        }
        let mut sensors = [0, 1, 2].map(|c| {
            let row = from_xyz.0[c];
            (0..BINS).map(|b| (0..3).map(|i| row[i] * by.weights[i][b]).sum::<f64>() / shown[c]).collect::<Vec<f64>>()
        });
        let literal = channels == Channels::Literal;
        let mut white = if literal { shown.map(|c| 0.01 * c) } else { [1.0; 3] };
        let finish = match channels {
            Channels::White => {
                let Some(own) = Xy::of(dominant.xyz()) else { return invalid!("the dominant light is black") };
                adapt::von_kries(Cat::Cmccat2000, Xy::D65, own, 1.0)?.times(&to_xyz)
            }
            Channels::Relative => to_xyz.times(&Mat3::diagonal(shown.map(|c| 0.01 * c))),
            Channels::Literal | Channels::Product => to_xyz,
        };
        let weights = |light: &Lit| {
            let own = sensed(light);
            let amount = match channels {
                Channels::White => [if light.scale > 0.0 { 100.0 } else { 0.0 }; 3],
                Channels::Product => own,
                Channels::Relative | Channels::Literal => [0, 1, 2].map(|c| 100.0 * own[c] / shown[c]),
            };
            // From blue to red, as wavelengths ascend.
            [0, 1, 2].map(|i| [2, 1, 0].map(|c| finish.0[i][c] * amount[c]).to_vec())
        };
        let rule = Rule { nodes_nm: AT_NM.to_vec(), weights: survey.lights.iter().map(weights).collect() };
        sensors.reverse();
        white.reverse();
        Ok(Converter { sensors, white, rule })
    }

    /// What paths carry in a scene.
    pub fn few(&self, survey: &Survey, scene: &Scene) -> Few {
        Few { rule: survey.scaled(&self.rule), converted: Some(self.convert(scene)) }
    }

    /// The rule for lights of Y = 100.
    pub fn rule(&self) -> &Rule {
        &self.rule
    }

    /// Means of a spectrum by channel, blue first; no less than 0.
    fn means(&self, fine: &[f64]) -> [f64; 3] {
        self.sensors.each_ref().map(|s| s.iter().zip(fine).map(|(a, b)| a * b).sum::<f64>().max(0.0))
    }

    /// A share of light that is left, in channels.
    pub fn share(&self, fine: &[f64]) -> [f64; 3] {
        let means = self.means(fine);
        [0, 1, 2].map(|c| means[c] * self.white[c])
    }

    /// A survey whose candidates are the channels.
    pub fn survey(&self, survey: &Survey) -> Survey {
        let mut own = Survey { candidates_nm: AT_NM.to_vec(), ..survey.clone() };
        own.shares.iter_mut().for_each(|s| s.at = self.share(&s.fine).to_vec());
        own
    }

    fn convert(&self, scene: &Scene) -> Converted {
        let at = |channels: [f64; 3]| Spectrum::Table(AT_NM.into_iter().zip(channels).collect());
        let reflectance = |s: &Spectrum| at(self.share(&fine(|nm| s.at(nm))));
        let ink = |ink: &Ink| match ink {
            Ink::Reflectance(s) | Ink::Reradiation { reflectance: s, .. } => Ink::Reflectance(reflectance(s)),
            Ink::Depth(s) => Ink::Depth(at(self.means(&fine(|nm| s.at(nm))))),
            Ink::Index { n, k } => {
                let normal = self.means(&fine(|nm| fresnel::conductor(1.0, n.at(nm) as f32, k.at(nm) as f32).into()));
                let n = self.means(&fine(|nm| n.at(nm)));
                let k = [0, 1, 2].map(|c| {
                    let (n, r) = (n[c], normal[c].min(0.9999));
                    // R = ((n - 1)^2 + k^2) / ((n + 1)^2 + k^2).
                    ((r * (n + 1.0).powi(2) - (n - 1.0).powi(2)) / (1.0 - r)).max(0.0).sqrt()
                });
                Ink::Index { n: at(n), k: at(k) }
            }
            other => other.clone(),
        };
        Converted { inks: scene.inks.iter().map(ink).collect(), srgb: scene.srgb.each_ref().map(reflectance) }
    }
}
