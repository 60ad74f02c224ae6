//! A scene's spectra in lanes, and what a tint makes of light that comes by.

use std::sync::Arc;

use crate::material::tint::Rulings;
use crate::material::{Base, Ink, Polar, Tint, tint};
use crate::optics::aperture::Airy;
use crate::optics::dipole::Dipole;
use crate::optics::fresnel;
use crate::optics::polarization::{Diattenuation, sheet};
use crate::render::beam::Beam;
use crate::render::films::Films;
use crate::render::lanes::{GROUP, Lanes};
use crate::render::reradiate::Dye;
use crate::simd;
use crate::spectral::{Sampling, Spectrum};

/// A scene's inks sampled to 8 G lanes.
pub struct Inks<const G: usize> {
    inks: Vec<Sampled<G>>,
    /// As they were, for what is worked out a wavelength at a time.
    plain: Vec<Ink>,
    rgb: [Lanes<G>; 3],
    /// The wavelength of each lane, nm; of those beyond the last, the last's.
    nm: Lanes<G>,
    count: usize,
    /// Radiance of each light, for what does not keep its wavelength; `None` where that is left out.
    lights: Option<Vec<Lanes<G>>>,
}

/// One ink in lanes.
enum Sampled<const G: usize> {
    One(Lanes<G>),
    Index(Lanes<G>, Lanes<G>),
    Films(Films<G>),
    Dye(Dye<G>),
    Grating(Arc<Rulings>, Lanes<G>),
    Dipole(Box<Sources<G>>),
}

/// A dipole's two sources, and the coefficients that they come of.
struct Sources<const G: usize> {
    coefficients: [Lanes<G>; 2],
    eta: f64,
    /// alpha' / 4 pi, z_r, z_v, sigma_tr.
    lanes: [Lanes<G>; 4],
}

impl<const G: usize> Sources<G> {
    fn new(scattering: Lanes<G>, absorption: Lanes<G>, eta: f64) -> Self {
        let mut lanes = [Lanes::splat(0.0); 4];
        for g in 0..G {
            for j in 0..GROUP {
                let d = Dipole::new(scattering.0[g][j].into(), absorption.0[g][j].into(), eta);
                if d.albedo > 0.0 {
                    let all = [d.albedo * 0.25 / std::f64::consts::PI, d.depth, d.height, d.transport];
                    lanes.iter_mut().zip(all).for_each(|(lanes, x)| lanes.0[g][j] = x as f32);
                }
            }
        }
        Sources { coefficients: [scattering, absorption], eta, lanes }
    }

    /// R_d at a distance in metres, 1/m2: see [`Dipole::radial`].
    #[inline(always)]
    fn radial(&self, metres: f32) -> Lanes<G> {
        let [strength, depth, height, transport] = &self.lanes;
        let source = |z: f32, tr: f32| {
            let d2 = (metres * metres + z * z).max(1e-30);
            let d = d2.sqrt();
            z / d2 * (1.0 / d + tr) * simd::exp(-tr * d)
        };
        let mut sum = depth.map2(transport, source);
        sum.add_scaled(&height.map2(transport, source), 1.0);
        sum.multiply(strength);
        sum
    }
}

/// What lanes stand for.
struct Cells {
    /// From and to, nm.
    edges: Vec<(f64, f64)>,
}

impl Cells {
    fn of(sampling: &Sampling) -> Cells {
        let edges = |i| {
            let (a, b) = sampling.edges(i);
            (a.min(b), a.max(b))
        };
        Cells { edges: (0..sampling.count()).map(edges).collect() }
    }

    fn middles<const G: usize>(&self) -> Lanes<G> {
        let last = self.edges.last().map_or(555.0, |(a, b)| 0.5 * (a + b));
        let middle = |i: usize| self.edges.get(i).map_or(last, |(a, b)| 0.5 * (a + b));
        Lanes::from_values(&(0..GROUP * G).map(middle).collect::<Vec<_>>())
    }
}

impl<const G: usize> Inks<G> {
    /// Samples a scene's inks and the basis of its RGB colours.
    pub fn new(inks: &[Ink], rgb: &[Spectrum; 3], sampling: &Sampling) -> Self {
        Self::by(inks, rgb, &Cells::of(sampling), |s| Lanes::from_values(&sampling.sample(s)), Some(sampling))
    }

    /// The same, with the lights that fluorescence needs to know; what it makes of them is light number `lights.len()`, of radiance 1.
    pub fn with_lights(mut self, lights: &[&Spectrum], sampling: &Sampling) -> Self {
        if self.inks.iter().any(|i| matches!(i, Sampled::Dye(_))) {
            let lanes = |l: &&Spectrum| Lanes::from_values(&sampling.sample(l));
            self.lights = Some(lights.iter().map(lanes).collect());
        }
        self
    }

    fn by(
        inks: &[Ink],
        rgb: &[Spectrum; 3],
        cells: &Cells,
        lanes: impl Fn(&Spectrum) -> Lanes<G>,
        sampling: Option<&Sampling>,
    ) -> Self {
        let sampled = |ink: &Ink| match ink {
            Ink::Reflectance(s) | Ink::Depth(s) => Sampled::One(lanes(s)),
            Ink::Index { n, k } => Sampled::Index(lanes(n), lanes(k)),
            Ink::Film(stack) => Sampled::Films(Films::new(stack, &cells.edges)),
            Ink::Grating(rulings) => Sampled::Grating(rulings.clone(), lanes(&rulings.reflectance)),
            Ink::Dipole { scattering, absorption, eta } => {
                Sampled::Dipole(Box::new(Sources::new(lanes(scattering), lanes(absorption), *eta)))
            }
            Ink::Reradiation { reflectance, dye } => match sampling {
                Some(sampling) => Sampled::Dye(Dye::new(lanes(reflectance), dye, sampling)),
                // An outline: what keeps its wavelength, and what does not.
                None => Sampled::Index(lanes(reflectance), lanes(&dye.given())),
            },
        };
        Inks {
            inks: inks.iter().map(sampled).collect(),
            plain: inks.to_vec(),
            rgb: rgb.each_ref().map(&lanes),
            nm: cells.middles(),
            count: cells.edges.len(),
            lights: None,
        }
    }

    /// An ink of one spectrum.
    #[inline(always)]
    pub fn one(&self, i: u32) -> &Lanes<G> {
        match &self.inks[i as usize] {
            Sampled::One(lanes) | Sampled::Index(lanes, _) | Sampled::Grating(_, lanes) => lanes,
            Sampled::Dye(dye) => &dye.reflectance,
            Sampled::Films(films) => &films.black,
            Sampled::Dipole(sources) => &sources.coefficients[0],
        }
    }

    /// A base that is no plain ink.
    #[inline(always)]
    fn mixed(&self, base: &Base) -> Lanes<G> {
        match base {
            Base::Grey(r) => Lanes::splat(*r),
            Base::Ink(i) => *self.one(*i),
            Base::Rgb(c) => {
                let mut sum = Lanes::splat(0.0);
                for (basis, c) in self.rgb.iter().zip(c) {
                    sum.add_scaled(basis, *c);
                }
                sum
            }
        }
    }

    /// What a tint leaves of light; it is turned where it turns.
    #[inline(always)]
    pub fn tint(&self, light: &mut Lanes<G>, tint: &Tint) {
        match tint {
            Tint::Base(Base::Ink(i)) => light.multiply(self.one(*i)),
            Tint::Base(Base::Grey(r)) => light.scale(*r),
            Tint::Inside { .. } | Tint::Collision { .. } | Tint::Glow { .. } | Tint::Null { .. } => {
                self.tint_in_media(light, tint);
            }
            other => self.tint_slowly(light, other),
        }
    }

    /// Exponentials of all wavelengths, most of a cloud's work: compiled once for each instruction set.
    #[inline(never)]
    fn tint_in_media(&self, light: &mut Lanes<G>, tint: &Tint) {
        simd::wide(
            #[inline(always)]
            || match *tint {
                Tint::Inside { depth, metres, over } => {
                    light.multiply_by([self.one(depth); 2], |d, _| over * simd::exp(-d * metres));
                }
                Tint::Collision { depth, scattering, metres, over } => {
                    let both = [depth, scattering].map(|i| self.one(i));
                    light.multiply_by(both, |d, s| over * s * simd::exp(-d * metres));
                }
                Tint::Glow { depth, part, metres } => {
                    light.multiply_by([depth, part].map(|i| self.one(i)), |d, p| tint::glow(d, p, metres));
                }
                Tint::Null { depth, share } => light.multiply_by([self.one(depth); 2], |d, _| 1.0 - d * share),
                _ => {}
            },
        );
    }

    #[inline(never)]
    fn tint_slowly(&self, light: &mut Lanes<G>, tint: &Tint) {
        match *tint {
            Tint::None => {}
            Tint::Base(base) => light.multiply(&self.mixed(&base)),
            Tint::Beneath(base, k) => light.multiply(&self.mixed(&base).map(|r| tint::beneath(r, k))),
            Tint::Metal { index, cos_half } => light.multiply(&self.metal(index, cos_half)),
            Tint::Repeated { mean, albedo } => light.multiply(&self.one(mean).map(|r| tint::repeated(r, albedo))),
            Tint::Panes { depth, stack, back } => {
                if let Some(k) = self.scalar(tint) {
                    return light.scale(k);
                }
                light.multiply(&self.one(depth).map(|d| stack.share(d, back)));
            }
            Tint::Boundary { index, cos, front, through } => {
                light.multiply(&self.one(index).map(|n| tint::boundary(cos, n, front, through)));
            }
            Tint::Facet { index, front, cos_half } => {
                light.multiply(&self.one(index).map(|n| tint::boundary(cos_half, n, front, false)));
            }
            Tint::Squeezed { index, front } => light.multiply(&self.one(index).map(|n| tint::squeezed(n, front))),
            Tint::Film { film, cos, through } => match &self.inks[film as usize] {
                Sampled::Films(films) => light.multiply(&films.share(cos, through)),
                _ => *light = Lanes::splat(0.0),
            },
            Tint::Inside { .. } | Tint::Collision { .. } | Tint::Glow { .. } | Tint::Null { .. } => {}
            Tint::Dipole { ink, metres } => {
                if let Sampled::Dipole(sources) = &self.inks[ink as usize] {
                    light.multiply(&sources.radial(metres));
                }
            }
            Tint::Fluorescent(i) => light.multiply(self.one(i)),
            Tint::Coherent { index, rough, cos } => {
                light.multiply(&self.metal(index, cos).map2(&self.nm, |r, nm| r * rough.coherent(cos, nm)));
            }
            Tint::Incoherent { index, rough, cosines } => {
                let scattering = tint::Scattering::new(&rough, cosines);
                light.multiply(&self.metal(index, cosines[2]).map2(&self.nm, |r, nm| r * scattering.at(nm)));
            }
            Tint::Grating { rulings, order, out: [x, y] } => {
                if let Sampled::Grating(r, reflectance) = &self.inks[rulings as usize] {
                    light.multiply(&reflectance.map2(&self.nm, |k, nm| k * r.share(order, x, y, nm)));
                }
            }
            Tint::Window(window) => {
                for (i, lane) in light.0.as_flattened_mut().iter_mut().enumerate() {
                    *lane *= window.share(i);
                }
            }
            Tint::Airy { v_nm } => light.multiply(&self.airy(v_nm)),
        }
    }

    fn metal(&self, index: u32, cos: f32) -> Lanes<G> {
        match &self.inks[index as usize] {
            Sampled::Index(n, k) => n.map2(k, |n, k| fresnel::conductor(cos, n, k)),
            _ => Lanes::splat(0.0),
        }
    }

    /// Each wavelength's density of a direction over the mean of all by which it was drawn.
    fn airy(&self, v_nm: f32) -> Lanes<G> {
        let airy = Airy::get();
        let mut density = self.nm.map(|nm| (airy.drawn(f64::from(v_nm / nm)) / f64::from(nm * nm)) as f32);
        let sum: f32 = density.0.as_flattened()[..self.count].iter().sum();
        density.scale(if sum > 0.0 { self.count as f32 / sum } else { 0.0 });
        density
    }

    /// The factor of a tint that is the same at every wavelength.
    #[inline(always)]
    pub fn scalar(&self, tint: &Tint) -> Option<f32> {
        match tint {
            Tint::None => Some(1.0),
            Tint::Base(Base::Grey(r)) => Some(*r),
            // Clear and grey panes.
            Tint::Panes { depth, stack, back } => match &self.plain[*depth as usize] {
                Ink::Depth(Spectrum::Constant(d)) => Some(stack.share(*d as f32, *back)),
                _ => None,
            },
            _ => None,
        }
    }

    /// What a surface does to the polarization of all wavelengths alike.
    #[inline(always)]
    pub fn constant(&self, polar: &Polar, cos: f32) -> Option<Diattenuation> {
        polar.constant(cos, &self.plain)
    }

    /// What a surface does to the polarization of each wavelength, over what it does to the amount.
    #[inline(always)]
    pub fn polar(&self, polar: &Polar, cos: f32) -> [Lanes<G>; 3] {
        let mut all = [Lanes::splat(0.0); 3];
        match *polar {
            Polar::Film { film, through } => {
                if let Sampled::Films(films) = &self.inks[film as usize] {
                    return films.polar(cos, through);
                }
            }
            Polar::Index { index, front, through, .. } => {
                if let Sampled::Index(n, k) = &self.inks[index as usize] {
                    each(&mut all, |g, j| boundary(cos, n.0[g][j], k.0[g][j], front, through));
                    return all;
                }
            }
            Polar::Sheet { along, across, retardance_nm } => {
                let Diattenuation { a, b, .. } = sheet(along.into(), across.into(), 0.0).relative();
                let phase = self.nm.map(|nm| std::f32::consts::TAU * retardance_nm / nm);
                each(&mut all, |g, j| {
                    let (sin, cos) = phase.0[g][j].sin_cos();
                    Diattenuation { a, b: b * cos, c: -b * sin }
                });
                return all;
            }
            _ => {}
        }
        for i in 0..self.count {
            let (g, j) = (i / GROUP, i % GROUP);
            let Diattenuation { a, b, c } = polar.at(self.nm.0[g][j].into(), cos, &self.plain).relative();
            (all[0].0[g][j], all[1].0[g][j], all[2].0[g][j]) = (a, b, c);
        }
        all
    }

    /// A fluorescent surface.
    pub fn dye(&self, i: u32) -> Option<&Dye<G>> {
        if let Sampled::Dye(dye) = &self.inks[i as usize] { Some(dye) } else { None }
    }

    /// Number of what fluorescence makes of lights, and what ink number `i` makes of so much of them.
    #[inline(always)]
    pub fn reradiate<B: Beam<G>>(&self, i: u32, arrived: &[(u32, B)]) -> Option<(u32, Lanes<G>)> {
        let (Some(lights), Sampled::Dye(dye)) = (&self.lights, &self.inks[i as usize]) else { return None };
        let own = lights.len() as u32;
        let mut sum = Lanes::splat(0.0);
        for (light, beam) in arrived {
            let factors = beam.intensity();
            match lights.get(*light as usize) {
                Some(radiance) => {
                    for (sums, (a, b)) in sum.0.iter_mut().zip(radiance.0.iter().zip(&factors.0)) {
                        for j in 0..GROUP {
                            sums[j] += a[j] * b[j];
                        }
                    }
                }
                None => sum.add_scaled(factors, 1.0),
            }
        }
        Some((own, dye.reradiated(&sum)))
    }
}

/// Three numbers a lane.
#[inline(always)]
fn each<const G: usize>(all: &mut [Lanes<G>; 3], of: impl Fn(usize, usize) -> Diattenuation) {
    for g in 0..G {
        for j in 0..GROUP {
            let Diattenuation { a, b, c } = of(g, j);
            (all[0].0[g][j], all[1].0[g][j], all[2].0[g][j]) = (a, b, c);
        }
    }
}

/// See [`Polar::Index`].
#[inline(always)]
fn boundary(cos: f32, n: f32, k: f32, front: bool, through: bool) -> Diattenuation {
    let eta = if front { n } else { 1.0 / n.max(f32::MIN_POSITIVE) };
    if through {
        fresnel::diattenuation_through(cos, eta)
    } else {
        fresnel::diattenuation(cos, eta, if front { k } else { 0.0 })
    }
}

/// Eight numbers for any number of wavelengths: how much a path still carries of what counts, near enough for the lots that
/// decide whether it goes on. Each stands for an eighth of the wavelengths, by their mean: a path is worth about the same however
/// finely its wavelengths are divided, and never nothing where there is something.
pub struct Outline {
    inks: Inks<1>,
    /// How much each eighth counts in X, Y and Z: the largest of the three sums is what a path is worth. `None` where every
    /// wavelength is asked for by itself, and the largest counts.
    shares: Option<[Lanes<1>; 3]>,
}

impl Outline {
    /// `counts` says how much each wavelength counts in three sums, `None` that each is asked for by itself; where none counts in
    /// a sum, all do.
    pub fn new(inks: &[Ink], rgb: &[Spectrum; 3], sampling: &Sampling, counts: Option<&[Vec<f64>; 3]>) -> Outline {
        let each = sampling.count().div_ceil(GROUP);
        let all = vec![1.0; sampling.count()];
        let or_all = |c: &[f64]| if c.iter().sum::<f64>() > 0.0 { c.to_vec() } else { all.clone() };
        let share = |c: &[f64]| {
            let c = or_all(c);
            let total: f64 = c.iter().sum();
            Lanes::from_values(&c.chunks(each).map(|c| c.iter().sum::<f64>() / total).collect::<Vec<_>>())
        };
        let shares = counts.map(|c| c.each_ref().map(|c| share(c.as_slice())));
        let joint = |[x, y, z]: &[Vec<f64>; 3]| (0..all.len()).map(|i| x[i] + y[i] + z[i]).collect::<Vec<_>>();
        let counts = counts.map_or_else(|| all.clone(), |c| or_all(&joint(c)));
        let sums: Vec<f64> = counts.chunks(each).map(|c| c.iter().sum()).collect();
        let mean = |values: &[f64], counts: &[f64], sum: f64| match sum {
            0.0 => values.iter().sum::<f64>() / values.len() as f64,
            sum => values.iter().zip(counts).map(|(v, c)| v * c).sum::<f64>() / sum,
        };
        let lanes = |s: &Spectrum| {
            let values = sampling.sample(s);
            let parts = values.chunks(each).zip(counts.chunks(each)).zip(&sums);
            Lanes::from_values(&parts.map(|((v, c), sum)| mean(v, c, *sum)).collect::<Vec<_>>())
        };
        let edges: Vec<(f64, f64)> = Cells::of(sampling).edges;
        let joined = |c: &[(f64, f64)]| c.iter().fold((f64::MAX, 0.0f64), |e, c| (e.0.min(c.0), e.1.max(c.1)));
        let cells = Cells { edges: edges.chunks(each).map(joined).collect() };
        Outline { inks: Inks::by(inks, rgb, &cells, lanes, None), shares }
    }

    /// What a tint leaves.
    #[inline]
    pub fn tint(&self, carried: &mut Lanes<1>, tint: &Tint) {
        match tint {
            // Which of the wavelengths a path still carries is the same for all its parts.
            Tint::Window(_) | Tint::Airy { .. } => {}
            // What goes in keeps its wavelength, or comes out where it is worth the most.
            Tint::Fluorescent(i) => {
                let most = carried.largest();
                if let Sampled::Index(reflectance, given) = &self.inks.inks[*i as usize] {
                    carried.multiply(reflectance);
                    carried.add_scaled(given, most);
                }
            }
            tint => self.inks.tint(carried, tint),
        }
    }

    /// A coefficient's means.
    pub fn one(&self, ink: u32) -> &Lanes<1> {
        self.inks.one(ink)
    }

    /// The dipoles of a body's eighths.
    pub fn dipoles(&self, ink: u32) -> Option<[Dipole; GROUP]> {
        let Sampled::Dipole(sources) = &self.inks.inks[ink as usize] else { return None };
        let [scattering, absorption] = sources.coefficients.each_ref().map(|c| c.0[0]);
        Some(std::array::from_fn(|i| Dipole::new(scattering[i].into(), absorption[i].into(), sources.eta)))
    }

    /// How many of the eighths there are: fewer where there are fewer wavelengths.
    pub fn lanes(&self) -> usize {
        self.inks.count
    }

    /// The eighths' shares of what is carried, by how much they count; a sum of 1.
    #[inline]
    pub fn shared(&self, carried: &Lanes<1>) -> Lanes<1> {
        let mut parts = *carried;
        match &self.shares {
            Some([x, y, z]) => {
                for i in 0..GROUP {
                    parts.0[0][i] *= x.0[0][i] + y.0[0][i] + z.0[0][i];
                }
            }
            // Those beyond the last count nothing.
            None => parts.0[0][self.inks.count..].fill(0.0),
        }
        let sum: f32 = parts.0[0].iter().sum();
        if sum > 0.0 && sum.is_finite() {
            parts.scale(1.0 / sum);
            return parts;
        }
        let mut even = Lanes::splat(0.0);
        even.0[0][..self.inks.count].fill(1.0 / self.inks.count as f32);
        even
    }

    /// How much that is in all.
    #[inline]
    pub fn value(&self, carried: &Lanes<1>) -> f32 {
        match &self.shares {
            Some(shares) => {
                let [x, y, z] = shares;
                carried.dot(x).max(carried.dot(y)).max(carried.dot(z))
            }
            None => carried.largest(),
        }
    }
}
