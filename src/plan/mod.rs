//! What a scene needs: the fewest wavelengths whose colours stay within a tolerance.
//!
//! [`survey`] lists the spectra that light of a scene can meet, [`products`] what becomes of light that meets several of them in turn,
//! [`fit`] makes a rule of K wavelengths for those, [`ladder`] takes the first rung whose worst product is good enough, and [`pilot`]
//! tries it on a few pixels; what fails there climbs a rung.

pub mod file;
pub mod fit;
pub mod ladder;
pub mod least;
pub mod pilot;
pub mod products;
pub mod survey;

use std::sync::Arc;

pub use ladder::{Plan, Rung};
pub use pilot::Pilot;

use crate::scene::Scene;
use crate::{Error, Result, usage};
use survey::Survey;

/// What is asked of a plan.
#[derive(Clone, Copy, Debug)]
pub struct Wish {
    /// Colour error of any pixel, Delta E 2000.
    pub tolerance: f64,
    /// Dark pixels are looked at up to so many times brighter.
    pub gain: f64,
    /// Pixels of the pilot; 0 for none.
    pub pilot: usize,
}

/// Of the pilot's worst: other pixels may be worse.
const MARGIN: f64 = 1.25;
/// Paths a pixel of the pilot.
const PATHS: u32 = 4;

impl Wish {
    /// Checked.
    ///
    /// # Errors
    /// A tolerance that is not above 0; of usage, a gain below 1.
    pub fn new(tolerance: f64, gain: f64, pilot: usize) -> Result<Wish> {
        if !(tolerance > 0.0 && tolerance <= 100.0) {
            return Err(Error::Invalid(format!("--tolerance {tolerance}: a Delta E 2000 above 0, such as 0.5")));
        }
        if !(1.0..=1e6).contains(&gain) {
            return usage!("--gain {gain}: a factor from 1, such as 10");
        }
        Ok(Wish { tolerance, gain, pilot })
    }

    /// Plans a scene: certificate first, then the pilot where there is a camera.
    pub fn plan(&self, scene: &Arc<Scene>) -> Result<(Plan, Option<Pilot>)> {
        let survey = Survey::of(scene)?;
        let mut least = 0;
        loop {
            let plan = Plan::of(&survey, self.tolerance, self.gain, least)?;
            let Some(rung) = plan.chosen.as_ref().filter(|_| self.pilot > 0 && scene.camera.is_some()) else {
                return Ok((plan, None));
            };
            let white = products::viewing(&survey, self.gain).white;
            let pilot = Pilot::fly(scene, &rung.rule, white, self.gain, (self.pilot, PATHS))?;
            if MARGIN * pilot.worst <= self.tolerance {
                return Ok((plan, Some(pilot)));
            }
            least = rung.asked + 1;
        }
    }
}
