//! What travels: factors of a light's radiance, one a wavelength; or Stokes vectors of them. Who follows a trail is written once
//! for both, and light that nobody asks the polarization of costs nothing.

use crate::material::{Polar, Tint};
use crate::optics::polarization::{Diattenuation, Rotation};
use crate::render::inks::Inks;
use crate::render::lanes::{GROUP, Lanes};

/// Light on its way back to the eye.
pub trait Beam<const G: usize>: Clone + Send {
    /// None.
    fn dark() -> Self;

    /// Adds the same to each wavelength: I, Q, U and V.
    fn add(&mut self, vector: [f32; 4]);

    /// Its amount.
    fn intensity(&self) -> &Lanes<G>;

    /// The same to write.
    fn intensity_mut(&mut self) -> &mut Lanes<G>;

    /// Adds k times another.
    fn add_scaled(&mut self, other: &Self, k: f32);

    /// Tinted.
    fn tint(&mut self, inks: &Inks<G>, tint: &Tint);

    /// Polarised, and then seen in a turned frame.
    fn polarise(&mut self, _inks: &Inks<G>, _polar: &Polar, _cos: f32, _turn: &Rotation) {}

    /// Unpolarised again.
    fn depolarise(&mut self) {}

    /// I, Q, U and V, where they are told apart.
    fn stokes(&self) -> Option<&[Lanes<G>; 4]> {
        None
    }
}

impl<const G: usize> Beam<G> for Lanes<G> {
    #[inline(always)]
    fn dark() -> Self {
        Lanes::splat(0.0)
    }

    #[inline(always)]
    fn add(&mut self, [i, ..]: [f32; 4]) {
        Lanes::add(self, i);
    }

    #[inline(always)]
    fn intensity(&self) -> &Lanes<G> {
        self
    }

    #[inline(always)]
    fn intensity_mut(&mut self) -> &mut Lanes<G> {
        self
    }

    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, k: f32) {
        Lanes::add_scaled(self, other, k);
    }

    #[inline(always)]
    fn tint(&mut self, inks: &Inks<G>, tint: &Tint) {
        inks.tint(self, tint);
    }
}

/// I, Q, U and V of each wavelength ([`crate::optics::polarization`]).
#[derive(Clone, Debug)]
pub struct Stokes<const G: usize>(pub [Lanes<G>; 4]);

impl<const G: usize> Stokes<G> {
    /// Each wavelength through a matrix of its own, and then seen in a turned frame.
    #[inline(always)]
    fn pass(&mut self, turn: &Rotation, of: impl Fn(usize, usize) -> Diattenuation) {
        for g in 0..G {
            for j in 0..GROUP {
                let vector = [self.0[0].0[g][j], self.0[1].0[g][j], self.0[2].0[g][j], self.0[3].0[g][j]];
                let [i, q, u, v] = turn.apply(of(g, j).apply(vector));
                self.0[0].0[g][j] = i;
                self.0[1].0[g][j] = q;
                self.0[2].0[g][j] = u;
                self.0[3].0[g][j] = v;
            }
        }
    }
}

impl<const G: usize> Beam<G> for Stokes<G> {
    #[inline(always)]
    fn dark() -> Self {
        Stokes([Lanes::splat(0.0); 4])
    }

    #[inline(always)]
    fn add(&mut self, vector: [f32; 4]) {
        for (lanes, x) in self.0.iter_mut().zip(vector).filter(|(_, x)| *x != 0.0) {
            lanes.add(x);
        }
    }

    #[inline(always)]
    fn intensity(&self) -> &Lanes<G> {
        &self.0[0]
    }

    #[inline(always)]
    fn intensity_mut(&mut self) -> &mut Lanes<G> {
        &mut self.0[0]
    }

    #[inline(always)]
    fn add_scaled(&mut self, other: &Self, k: f32) {
        for i in 0..4 {
            self.0[i].add_scaled(&other.0[i], k);
        }
    }

    #[inline(always)]
    fn tint(&mut self, inks: &Inks<G>, tint: &Tint) {
        if let Some(k) = inks.scalar(tint) {
            return self.0.iter_mut().for_each(|lanes| lanes.scale(k));
        }
        let mut factor = Lanes::splat(1.0);
        inks.tint(&mut factor, tint);
        for i in 0..4 {
            self.0[i].multiply(&factor);
        }
    }

    #[inline(always)]
    fn polarise(&mut self, inks: &Inks<G>, polar: &Polar, cos: f32, turn: &Rotation) {
        if let Some(constant) = inks.constant(polar, cos) {
            return self.pass(turn, |_, _| constant);
        }
        let [a, b, c] = inks.polar(polar, cos);
        self.pass(turn, |g, j| Diattenuation { a: a.0[g][j], b: b.0[g][j], c: c.0[g][j] });
    }

    fn depolarise(&mut self) {
        for i in 1..4 {
            self.0[i] = Lanes::splat(0.0);
        }
    }

    #[inline(always)]
    fn stokes(&self) -> Option<&[Lanes<G>; 4]> {
        Some(&self.0)
    }
}
