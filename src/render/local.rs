//! Local illumination: the paper's cheap approximation, "a simple sum over light sources and a general ambient term", with its
//! tricks: shadows or none, reflections of what lies around the scene or none, an ambient term.
//!
//! A surface shows the lamps in each of its lobes. What other surfaces would send it is one radiance from everywhere: the one
//! that keeps the scene's balance of light ([`Balance`]), one that is given, or none. Lobes that are not matt show lamps and
//! sky in their own direction, and the ambient radiance where a surface lies there. Light goes straight on through panes.
//!
//! It cannot show what surfaces show of each other: colour that bleeds, bright and dark parts of indirect light, mirrored
//! rooms, light bent by glass, caustics.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;
use std::sync::Arc;

use glam::Vec3A;

use crate::material::{Base, Ink, Lobe, Tint};
use crate::medium::Inside;
use crate::notes::Notes;
use crate::render::balance::Balance;
use crate::render::meeting::Meeting;
use crate::render::method::Method;
use crate::render::sampler::Sampler;
use crate::render::shade::{Follow, Pairs, Rest, Shade};
use crate::render::trail::Trail;
use crate::render::view::{self, Eye};
use crate::scene::light::Emission;
use crate::scene::{Hit, Scene};
use crate::{Result, invalid, string_serde};

/// The first pair of a sampler's numbers that is free.
const FIRST_PAIR: u32 = 2;
/// A share of interreflected light that is worth a word: one constant stands for all of it.
const STRONG: f64 = 0.2;

/// What comes from where light is not known; `auto`, or a luminance in cd/m2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Term {
    /// What keeps the scene's balance.
    Balance,
    /// A luminance in cd/m2, of the balance's colour.
    Luminance(f64),
}

impl FromStr for Term {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        if text == "auto" {
            return Ok(Term::Balance);
        }
        match text.parse() {
            Ok(cd_m2) if (0.0..=1e9).contains(&cd_m2) => Ok(Term::Luminance(cd_m2)),
            _ => Err("expected auto, or a luminance in cd/m2 from 0 to 1e9".into()),
        }
    }
}

impl Display for Term {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        match self {
            Term::Balance => f.write_str("auto"),
            Term::Luminance(cd_m2) => write!(f, "{cd_m2}"),
        }
    }
}

string_serde!(Term);

/// What can be asked of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The ambient term.
    pub ambient: Term,
    /// Lamps may be hidden.
    pub shadows: bool,
    /// Lobes that are not matt show lamps and sky.
    pub reflections: bool,
}

/// For each light the number of its spectrum, and its tint by a spectrum of factors: one radiance from everywhere.
struct Ambient {
    tints: Vec<(u32, Tint)>,
    /// Share of the directions of a place in which there are surfaces.
    closed: f32,
}

impl Ambient {
    fn note(&self, weight: f32, trail: &mut Trail) {
        for (light, tint) in &self.tints {
            trail.tint(tint);
            trail.light(&Emission::one(*light, 1.0), weight, 1);
        }
    }
}

impl Rest for Ambient {
    fn spread(&self, _: &Meeting, _: &Lobe, weight: f32, trail: &mut Trail) {
        self.note(weight * self.closed, trail);
    }

    fn sent(&self, _: Option<&Hit>, _: Vec3A, weight: f32, _: &mut Pairs, trail: &mut Trail) {
        self.note(weight, trail);
    }
}

/// Local illumination of a scene.
pub struct Local {
    scene: Arc<Scene>,
    options: Options,
    balance: Balance,
    ambient: Ambient,
    inks: Vec<Ink>,
}

impl Local {
    /// Balances the scene's light over wavelengths in nm.
    pub fn new(scene: Arc<Scene>, options: Options, range_nm: (f64, f64)) -> Result<Local> {
        let balance = Balance::of(&scene, range_nm)?;
        let [found, _] = balance.luminance_cd_m2;
        let factor = match options.ambient {
            Term::Balance => 1.0,
            Term::Luminance(0.0) => 0.0,
            Term::Luminance(cd_m2) if found > 0.0 => cd_m2 / found,
            Term::Luminance(cd_m2) => {
                return invalid!(
                    "no surface reflects visible light: an ambient term of {cd_m2} cd/m2 would have no colour"
                );
            }
        };
        // What was asked for is taken at its word.
        let closed = if options.ambient == Term::Balance { balance.closed as f32 } else { 1.0 };
        let mut local =
            Local { scene, options, balance, ambient: Ambient { tints: Vec::new(), closed }, inks: Vec::new() };
        if factor > 0.0 {
            for (light, factors) in &local.balance.ambient {
                let ink = (local.scene.inks.len() + local.inks.len()) as u32;
                local.ambient.tints.push((*light, Tint::Base(Base::Ink(ink))));
                local.inks.push(Ink::Reflectance(factors.scaled(factor)));
            }
        }
        Ok(local)
    }

    fn shade(&self, inside: Inside) -> Shade<'_> {
        let Options { shadows, reflections, .. } = self.options;
        let follow = if reflections { Follow::Gloss } else { Follow::Nothing };
        Shade { scene: &self.scene, rest: &self.ambient, shadows, follow, inside }
    }
}

impl Method for Local {
    fn radiance(&self, origin: Vec3A, direction: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let (scene, mut pairs) = (&*self.scene, Pairs::new(sampler, FIRST_PAIR));
        Eye { scene, origin, direction }.look(
            &mut pairs,
            trail,
            |lobe| lobe.kernel.is_straight(),
            |inside, way, pairs, trail| view::dim(scene, inside, way, pairs, trail),
            |seen, lobe, pairs, trail| self.shade(seen.inside).lobe(seen.at, lobe, pairs, trail),
        );
    }

    fn irradiance(&self, point: Vec3A, normal: Vec3A, sampler: &Sampler, trail: &mut Trail) {
        let at = Meeting::facing(point, normal);
        self.shade(self.scene.inside(point)).lobe(&at, &Lobe::WHITE, &mut Pairs::new(sampler, FIRST_PAIR), trail);
    }

    fn inks(&self) -> &[Ink] {
        &self.inks
    }

    fn report(&self, notes: &Notes) {
        let Balance { luminance_cd_m2: [balanced, error], interreflected, closed, .. } = &self.balance;
        let used = match self.options.ambient {
            Term::Balance => String::new(),
            Term::Luminance(cd_m2) => format!("; {cd_m2} is used"),
        };
        notes.add(format!(
            "local illumination: surfaces see others in {:.1} % of their directions, {:.1} % of their light comes from others; an \
             ambient term of {balanced:.4} +- {error:.1e} cd/m2 keeps the balance{used}",
            100.0 * closed,
            100.0 * interreflected
        ));
        if *interreflected > STRONG {
            notes.add(
                "one ambient radiance stands for strong interreflection, which differs from place to place: see --method path",
            );
        }
    }
}
