//! Light that leaves a body elsewhere than where it went in: a place around, drawn by the dipole's profile on one of three axes
//! through the point that is seen (one along the normal, two across it) and by the rates of the eighths of the wavelengths, all weighed
//! together [King 2013].

use glam::Vec3A;

use crate::material::Tint;
use crate::optics::dipole::Dipole;
use crate::render::inks::Outline;
use crate::render::lanes::{self, GROUP};
use crate::render::meeting::Meeting;
use crate::render::path::Tracer;
use crate::render::path::state::{Beside, State};
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;
use crate::scene::{Hit, Scene, ray};

/// Pairs of a sampler's numbers that this takes, two a bounce.
const FIRST: u32 = 0x3000_0000;
/// Surfaces that one line may cross.
const MOST_CROSSED: usize = 32;
/// Lots of the axes: normal, and either tangent.
const AXES: [f32; 3] = [0.5, 0.25, 0.25];
/// Share of the light that leaves within the length of the lines.
const LINE: f64 = 0.998;

/// The dipoles of the eighths of the wavelengths.
pub struct Dipoles {
    each: [Dipole; GROUP],
    /// Half the length of lines, m.
    reach_m: f64,
}

impl Dipoles {
    /// Of one ink, in a picture whose spectra have this outline.
    pub fn new(outline: &Outline, ink: u32) -> Option<Dipoles> {
        let each = outline.dipoles(ink)?;
        let reach_m = each.iter().map(|d| d.radius(LINE)).fold(0.0, f64::max);
        Some(Dipoles { each, reach_m })
    }

    /// Density of a distance along a plane, 1/m2, by lots of the eighths.
    fn density(&self, shares: &[f32; GROUP], r_m: f64) -> f64 {
        let one = |(d, share): (&Dipole, &f32)| {
            if *share > 0.0 { f64::from(*share) * d.radial(r_m) / d.total() } else { 0.0 }
        };
        self.each.iter().zip(shares).map(one).sum()
    }

    /// Lots of the eighths: what a path carries of each, times what comes back of it.
    fn shares(&self, carried: &[f32]) -> [f32; GROUP] {
        let mut shares = [0f32; GROUP];
        for ((share, carried), dipole) in shares.iter_mut().zip(carried).zip(&self.each) {
            *share = carried * dipole.total() as f32;
        }
        let sum: f32 = shares.iter().sum();
        if sum > 0.0 { shares.map(|s| s / sum) } else { shares }
    }
}

impl<E: Beside> Tracer<'_, E> {
    /// Goes from where light leaves a body to where it went in, and notes what the wavelengths lose; `None` where nothing is met.
    #[inline(never)]
    pub(super) fn beneath(
        &self,
        ink: u32,
        hit: &Hit,
        at: &Meeting,
        state: &mut State<E>,
        sampler: &Sampler,
        trail: &mut Trail,
    ) -> Option<Meeting> {
        let (scene, outline) = (self.scene, self.outline);
        let dipoles = self.dipoles.iter().find(|d| d.0 == ink).map(|d| &d.1)?;
        let shares = dipoles.shares(outline.shared(&state.outline).0.as_flattened());
        let [lots, places] = [0, 1].map(|i| sampler.pair(FIRST + 2 * state.bounce + i));
        let (axis, lot) = if lots[0] < AXES[0] {
            (0, lots[0] / AXES[0])
        } else {
            let rest = (lots[0] - AXES[0]) / (1.0 - AXES[0]);
            if rest < 0.5 { (1, 2.0 * rest) } else { (2, 2.0 * rest - 1.0) }
        };
        let r_m = dipoles.each[lanes::chosen(&shares, lot)].radius(lots[1].into());
        // The normal first, then the tangents.
        let axes = [at.axes[2], at.axes[0], at.axes[1]];
        let (s, t, along) = (axes[(axis + 1) % 3], axes[(axis + 2) % 3], axes[axis]);
        let (sin, cos) = (places[0] * std::f32::consts::TAU).sin_cos();
        let units = |m: f64| (m * scene.frame.scale) as f32;
        let off = (s * cos + t * sin) * units(r_m);
        let reach = units(dipoles.reach_m);
        let crossed = crossed(scene, hit.surface.material, hit.point + off + along * reach, -along, 2.0 * reach);
        let count = crossed.len();
        let met = crossed.get(((places[1] * count as f32) as usize).min(count.checked_sub(1)?))?;
        let from = met.point - hit.point;
        let mut density = 0.0;
        for (axis, lot) in axes.iter().zip(AXES) {
            let along = from.dot(*axis);
            if along.abs() <= reach {
                let r_m = f64::from((from - *axis * along).length()) / scene.frame.scale;
                density += f64::from(lot * met.normal.dot(*axis).abs()) * dipoles.density(&shares, r_m);
            }
        }
        if density.is_nan() || density <= 0.0 {
            return None;
        }
        state.weight *= (count as f64 / density) as f32;
        let metres = scene.frame.length_m(from.length());
        self.tint(state, &Tint::Dipole { ink, metres }, trail);
        let (_, shading) = scene.site(met, true);
        let (x, y) = ray::frame(shading);
        let axes = [x, y, shading];
        Some(Meeting {
            side: met.normal,
            point: met.point,
            reach: met.reach,
            axes,
            out: Vec3A::Z,
            matt: false,
            interior: None,
        })
    }
}

/// Surfaces of a material that a line crosses.
fn crossed(scene: &Scene, material: u32, mut from: Vec3A, direction: Vec3A, mut length: f32) -> Vec<Hit> {
    let mut all = Vec::new();
    while all.len() < MOST_CROSSED
        && let Some(hit) = scene.geometry.closest(from, direction).filter(|h| h.t <= length)
    {
        if hit.surface.material == material {
            all.push(hit);
        }
        let side = if hit.normal.dot(direction) < 0.0 { -hit.normal } else { hit.normal };
        let next = ray::offset(hit.point, side, hit.reach);
        length -= (next - from).length();
        from = next;
    }
    all
}
