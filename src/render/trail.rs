//! What happened to light on the way, noted from the eye on and worked out from the lamps back: light is tinted, more light
//! joins it, both are tinted.
//!
//! Carried from the eye forward, every lamp that a path finds would have to be weighed with all the path's wavelengths (3 K
//! products for XYZ). Backward it is K sums where it joins and K products a surface, and 3 K products once, at the eye. A path of
//! polarised or fluorescing light gains more: what comes back is a vector a wavelength or a spectrum, not a matrix.

use glam::Vec3A;

use crate::material::{Base, Polar, Tint};
use crate::optics::polarization::Rotation;
use crate::render::beam::Beam;
use crate::render::inks::Inks;
use crate::render::lanes::Lanes;
use crate::render::stored::Stored;
use crate::scene::light::Emission;

#[derive(Clone, Copy, Debug)]
enum Step {
    /// All that is noted after this goes through it.
    Tint(Tint),
    /// Light spectrum times a weight. The `aside` tints noted just before it are its alone.
    Light { light: u32, weight: f32, aside: u32 },
    /// A stored row times a weight.
    Stored { row: u32, weight: f32 },
    /// All that is noted after this is polarised, and its frame turned.
    Polar { polar: Polar, cos: f32, turn: Rotation },
    /// All that is noted after this is unpolarised from here on.
    Depolarise,
    /// All that is noted after this falls on a fluorescent surface.
    Reradiate(u32),
    /// What other paths found joins here ([`crate::render::pool`]).
    Pooled,
    /// Several branches start here.
    Fork,
    /// One of them.
    Branch,
    /// The last of them ends here, with all that is noted: needed where a branch that is not the last forks again.
    Join,
}

/// A path's notes. Emptied and used again for the next.
#[derive(Clone, Debug, Default)]
pub struct Trail {
    steps: Vec<Step>,
    /// Notes before this one are those of the path, whatever is noted aside.
    fence: usize,
    /// The axis, at right angles to the way, that polarised light at the eye is told by.
    pub frame: Vec3A,
}

impl Trail {
    /// Forgets everything.
    pub fn clear(&mut self) {
        self.steps.clear();
        self.fence = 0;
    }

    /// From here on tints are those of one light alone, until it is noted. Returns the number of notes so far.
    #[inline]
    pub fn aside(&mut self) -> usize {
        self.fence = self.steps.len();
        self.fence
    }

    /// Number of notes.
    #[inline]
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// Nothing happened.
    pub fn is_empty(&self) -> bool {
        self.steps.is_empty()
    }

    /// Light joins it.
    pub fn is_lit(&self) -> bool {
        self.steps.iter().any(|s| matches!(s, Step::Light { .. } | Step::Stored { .. }))
    }

    /// Forgets what came after the first `len` notes.
    pub fn truncate(&mut self, len: usize) {
        self.steps.truncate(len);
    }

    /// What comes after this is tinted by it.
    #[inline]
    pub fn tint(&mut self, tint: &Tint) {
        if let Tint::Inside { .. } = tint
            && self.steps.len() > self.fence
            && let Some(Step::Tint(last)) = self.steps.last_mut()
            && last.lengthen(tint)
        {
            return;
        }
        match tint {
            Tint::None => {}
            Tint::Fluorescent(ink) => self.steps.push(Step::Reradiate(*ink)),
            tint => self.steps.push(Step::Tint(*tint)),
        }
    }

    /// What comes after this is polarised by it, `cos` its cosine, and seen in a turned frame.
    pub fn polarise(&mut self, polar: &Polar, cos: f32, turn: Rotation) {
        self.steps.push(Step::Polar { polar: *polar, cos, turn });
    }

    /// What comes after this leaves unpolarised.
    pub fn depolarise(&mut self) {
        self.steps.push(Step::Depolarise);
    }

    /// What comes after this is dimmed, all wavelengths alike.
    pub fn scale(&mut self, k: f32) {
        if k != 1.0 {
            self.tint(&Tint::Base(Base::Grey(k)));
        }
    }

    /// Light joins, with a weight; the last `aside` tints are on its way alone.
    #[inline]
    pub fn light(&mut self, emission: &Emission, weight: f32, aside: usize) {
        for k in 0..emission.count as usize {
            // The tints stand before the last part; each of the others has a copy of them.
            let tints = self.steps.len() - aside..self.steps.len();
            let (light, weight) = (emission.light + k as u32, weight * emission.parts[k]);
            // More of the same light, and nothing between: one note for both.
            if aside == 0
                && let Some(Step::Light { light: last, weight: sum, aside: 0 }) = self.steps.last_mut()
                && *last == light
            {
                *sum += weight;
                continue;
            }
            self.steps.push(Step::Light { light, weight, aside: aside as u32 });
            if aside > 0 && k + 1 < emission.count as usize {
                self.steps.extend_from_within(tints);
            }
        }
    }

    /// Notes `count` tints again that stand from number `from` on: for another light on the same way.
    pub fn repeat(&mut self, from: usize, count: usize) {
        self.steps.extend_from_within(from..from + count);
    }

    /// Stored light joins, with a weight.
    #[inline]
    pub fn stored(&mut self, row: u32, weight: f32) {
        self.steps.push(Step::Stored { row, weight });
    }

    /// What other paths found joins.
    pub fn pooled(&mut self) {
        self.steps.push(Step::Pooled);
    }

    /// The path splits: [`Trail::branch`] starts each of its branches.
    pub fn fork(&mut self) {
        self.steps.push(Step::Fork);
    }

    /// All branches have been noted.
    pub fn join(&mut self) {
        self.steps.push(Step::Join);
    }

    /// What comes after this goes through what came before the fork.
    pub fn branch(&mut self) {
        self.steps.push(Step::Branch);
    }
}

/// What arrives at the eye of each light spectrum, as factors of it.
#[derive(Clone, Debug)]
pub struct Arrived<const G: usize, B = Lanes<G>> {
    /// Of the branch that is being worked on.
    here: Vec<(u32, B)>,
    /// Of the branches that were.
    joined: Vec<(u32, B)>,
    /// Where in it those of the forks begin that have been joined.
    forks: Vec<usize>,
}

impl<const G: usize, B> Default for Arrived<G, B> {
    fn default() -> Self {
        Arrived { here: Vec::new(), joined: Vec::new(), forks: Vec::new() }
    }
}

/// The beam of a light in a list, which it joins where it is not there yet.
#[inline(always)]
pub fn find<const G: usize, B: Beam<G>>(among: &mut Vec<(u32, B)>, light: u32) -> &mut B {
    find_from(among, 0, light)
}

#[inline(always)]
fn find_from<const G: usize, B: Beam<G>>(among: &mut Vec<(u32, B)>, from: usize, light: u32) -> &mut B {
    let i = among[from..].iter().position(|l| l.0 == light).unwrap_or_else(|| {
        among.push((light, B::dark()));
        among.len() - 1 - from
    });
    &mut among[from + i].1
}

impl<const G: usize, B: Beam<G>> Arrived<G, B> {
    /// Follows a trail back to the eye. Returns the number of each light that has come, and its factors.
    #[inline(always)]
    pub fn follow(&mut self, trail: &Trail, inks: &Inks<G>, stored: &Stored) -> &[(u32, B)] {
        self.follow_pooled(trail, inks, stored, &[])
    }

    /// The same of a trail that other paths' light joins, which is this.
    #[inline(always)]
    pub fn follow_pooled(
        &mut self,
        trail: &Trail,
        inks: &Inks<G>,
        stored: &Stored,
        pooled: &[(u32, B)],
    ) -> &[(u32, B)] {
        self.here.clear();
        self.joined.clear();
        self.forks.clear();
        let mut left = trail.steps.len();
        while left > 0 {
            left -= 1;
            match &trail.steps[left] {
                Step::Tint(tint) => {
                    // A loop: a closure would be compiled for the baseline.
                    for (_, beam) in &mut self.here {
                        beam.tint(inks, tint);
                    }
                }
                Step::Light { light, weight, aside: 0 } => {
                    find(&mut self.here, *light).add([*weight, 0.0, 0.0, 0.0]);
                }
                Step::Light { light, weight, aside } => {
                    let from = left - *aside as usize;
                    self.join(*light, *weight, &trail.steps[from..left], inks);
                    left = from;
                }
                Step::Stored { row, weight } => {
                    stored.add(find(&mut self.here, stored.light(*row)).intensity_mut(), *row, *weight);
                }
                Step::Polar { polar, cos, turn } => {
                    for (_, beam) in &mut self.here {
                        beam.polarise(inks, polar, *cos, turn);
                    }
                }
                Step::Depolarise => self.here.iter_mut().for_each(|(_, beam)| beam.depolarise()),
                Step::Reradiate(ink) => self.reradiate(*ink, inks),
                Step::Pooled => {
                    for (light, beam) in pooled {
                        find(&mut self.here, *light).add_scaled(beam, 1.0);
                    }
                }
                Step::Branch => {
                    let from = self.forks.last().copied().unwrap_or(0);
                    for (light, beam) in self.here.drain(..) {
                        find_from(&mut self.joined, from, light).add_scaled(&beam, 1.0);
                    }
                }
                Step::Join => self.forks.push(self.joined.len()),
                Step::Fork => match self.forks.pop() {
                    Some(from) => self.here.extend(self.joined.drain(from..)),
                    None => std::mem::swap(&mut self.here, &mut self.joined),
                },
            }
        }
        &self.here
    }

    /// Light joins that has a way of its own: as long as that does the same to all wavelengths, four numbers will do.
    #[inline(always)]
    fn join(&mut self, light: u32, weight: f32, aside: &[Step], inks: &Inks<G>) {
        let mut vector = [weight, 0.0, 0.0, 0.0];
        let mut left = aside.len();
        while left > 0 {
            match &aside[left - 1] {
                Step::Tint(tint) => match inks.scalar(tint) {
                    Some(k) => vector = vector.map(|x| x * k),
                    None => break,
                },
                Step::Polar { polar, cos, turn } => match inks.constant(polar, *cos) {
                    Some(d) => vector = turn.apply(d.apply(vector)),
                    None => break,
                },
                Step::Depolarise => vector = [vector[0], 0.0, 0.0, 0.0],
                _ => {}
            }
            left -= 1;
        }
        let at = find(&mut self.here, light);
        if left == 0 {
            return at.add(vector);
        }
        let mut beam = B::dark();
        beam.add(vector);
        for step in aside[..left].iter().rev() {
            match step {
                Step::Tint(tint) => beam.tint(inks, tint),
                Step::Polar { polar, cos, turn } => beam.polarise(inks, polar, *cos, turn),
                Step::Depolarise => beam.depolarise(),
                _ => {}
            }
        }
        at.add_scaled(&beam, 1.0);
    }

    /// What falls on a fluorescent surface becomes what it gives off.
    #[inline(always)]
    fn reradiate(&mut self, ink: u32, inks: &Inks<G>) {
        let given = inks.reradiate(ink, &self.here);
        for (_, beam) in &mut self.here {
            beam.tint(inks, &Tint::Fluorescent(ink));
        }
        if let Some((light, lanes)) = given {
            find(&mut self.here, light).intensity_mut().add_scaled(&lanes, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Ink;
    use crate::spectral::{Sampling, Spectrum};

    /// Ways through one medium that follow on each other are one note; never a look's with the path's before it.
    #[test]
    fn ways_are_joined_and_asides_are_not() {
        let inside = |depth, metres| Tint::Inside { depth, metres, over: 2.0 };
        let mut trail = Trail::default();
        trail.tint(&inside(0, 1.0));
        trail.tint(&inside(0, 3.0));
        trail.tint(&inside(1, 3.0));
        assert_eq!(trail.len(), 2);
        assert!(matches!(trail.steps[0], Step::Tint(Tint::Inside { depth: 0, metres: 4.0, over: 4.0 })));
        let before = trail.aside();
        trail.tint(&inside(1, 5.0));
        trail.tint(&inside(1, 5.0));
        trail.light(&Emission::one(0, 1.0), 1.0, trail.len() - before);
        trail.tint(&Tint::Collision { depth: 1, scattering: 0, metres: 1.0, over: 1.0 });
        trail.tint(&inside(1, 1.0));
        assert_eq!((before, trail.len()), (2, 5));
    }

    /// Followed backward a trail gives what is carried forward by hand: through a fork, with tints that are a lamp's alone.
    #[test]
    fn back_is_forth() {
        let ramp = |a: f64, b: f64| Spectrum::from_points(vec![(400.0, a), (700.0, b)]).unwrap();
        let spectra = [ramp(0.1, 0.9), ramp(0.8, 0.3), ramp(0.5, 0.6)];
        let sampling = Sampling::bins(400.0, 700.0, 11).unwrap();
        let basis = [ramp(1.0, 0.0), ramp(0.0, 1.0), ramp(0.0, 0.0)];
        let inks = Inks::<2>::new(&spectra.clone().map(Ink::Reflectance), &basis, &sampling);
        let ink = |i: u32| Tint::Base(Base::Ink(i));
        let mut trail = Trail::default();
        trail.light(&Emission::one(3, 2.0), 0.5, 0);
        trail.tint(&ink(0));
        trail.fork();
        trail.branch();
        trail.tint(&ink(2));
        let two = Emission { light: 3, count: 2, parts: [1.0, 0.25, 0.0, 0.0, 0.0, 0.0] };
        trail.light(&two, 4.0, 1);
        trail.tint(&ink(1));
        trail.light(&Emission::one(7, 1.0), 3.0, 0);
        trail.branch();
        trail.tint(&Tint::None);
        trail.tint(&Tint::Base(Base::Rgb([0.5, 0.25, 0.0])));
        trail.light(&Emission::one(7, 1.0), 8.0, 0);
        // Row 3 is of the second light again.
        let row = |k: f32| [[k; 11].as_slice(), &[0.0; 5]].concat();
        let stored = Stored { lights: vec![9, 7], lanes: 16, data: [row(1.0), row(2.0), row(3.0), row(4.0)].concat() };
        trail.stored(3, 0.5);
        let mut arrived = Arrived::<2>::default();
        let arrived = arrived.follow(&trail, &inks, &stored);
        let mut lights: Vec<u32> = arrived.iter().map(|l| l.0).collect();
        lights.sort_unstable();
        assert_eq!(lights, [3, 4, 7]);
        let [a, b, c] = spectra.map(|s| sampling.sample(&s));
        let [x, y, _] = basis.map(|s| sampling.sample(&s));
        for i in 0..sampling.count() {
            let want = [
                (3, 1.0 + 4.0 * a[i] * c[i]),
                (4, 0.25 * 4.0 * a[i] * c[i]),
                (7, a[i] * (b[i] * 3.0 + (0.5 * x[i] + 0.25 * y[i]) * (8.0 + 0.5 * 4.0))),
            ];
            for (light, want) in want {
                let lanes = &arrived.iter().find(|l| l.0 == light).unwrap().1;
                let got = f64::from(lanes.0.as_flattened()[i]);
                assert!((got - want).abs() < 1e-5 * want, "light {light}, wavelength {i}: {got} for {want}");
            }
        }
    }
}
