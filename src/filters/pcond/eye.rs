//! What an eye received, and what is shown in its place: the light of a picture before any adaptation, its rods' share, and
//! the colours after the change of white.

use crate::color::{Cat, Mat3, Xy, adapt, matrix};
use crate::error::printable;
use crate::simd::GROUP;
use crate::spectral::{Observer, builtin};
use crate::stream::header::Adapted;
use crate::stream::tristimulus::{integrated, tristimulus, weights};
use crate::stream::{Components, Header, Picture, Units};
use crate::tone::mesopic::{self, SCOTOPIC_EFFICACY, WHITE_SCOTOPIC, cone_share};
use crate::{Error, Result};

/// How pixels are seen and shown. Pixels are XYZ, or XYZ and scotopic luminance.
#[derive(Clone, Debug)]
pub struct Eye {
    /// The picture's XYZ to that before `vonkries`.
    undo: Option<[[f32; 3]; 3]>,
    /// The picture's XYZ to that under the white it is shown with.
    adapt: Option<[[f32; 3]; 3]>,
    /// Rods take part.
    rods: bool,
    /// XYZ of unit luminance of what rods see.
    grey: [f32; 3],
}

impl Eye {
    /// The eye for a picture, which becomes XYZ, with a fourth component V where there is a spectrum and rods see. `to` is the
    /// white it is to be shown with, from that of its header. The header is that of what is shown.
    pub fn of(input: Box<dyn Picture>, to: Option<Xy>, rods: bool) -> Result<(Eye, Box<dyn Picture>, Header)> {
        let header = input.header();
        let undo = header.adapted.as_ref().map(undoing).transpose()?.map(|m| m.to_f32());
        let mut shown = header.clone();
        let mut change = None;
        if let Some(to) = to {
            let from = header.white.ok_or_else(|| {
                Error::Invalid("the picture has no WHITE line; say what it was lit with: --white x,y or a name".into())
            })?;
            let (cat, degree) = (Cat::Cmccat2000, 1.0);
            change = Some(adapt::von_kries(cat, from, to, degree)?.to_f32());
            shown.adapted = Some(Adapted { from, to, cat: cat.name(), degree });
            shown.white = Some(to);
        }
        shown.become_tristimulus(Components::Xyz, Units::Display);
        let white = shown.white.unwrap_or(Xy::E);
        let grey = white.xyz().map(|x| x as f32);
        let spectrum = matches!(header.components, Components::Spectrum | Components::Stokes);
        let picture = if rods && spectrum { with_scotopic(input)? } else { tristimulus(input)? };
        Ok((Eye { undo, adapt: change, rods, grey }, picture, shown))
    }

    /// Scotopic luminance as received.
    #[inline(always)]
    fn scotopic(&self, pixel: &[f32]) -> f32 {
        match pixel.get(3) {
            Some(v) => *v,
            None => {
                let xyz = [pixel[0], pixel[1], pixel[2]];
                mesopic::scotopic(self.undo.map_or(xyz, |m| matrix::multiply(&m, xyz)))
            }
        }
    }

    /// Luminance in cd/m2 that cones would see.
    #[inline(always)]
    pub fn luminance_cd_m2(&self, pixel: &[f32]) -> f32 {
        match &self.undo {
            Some(m) => m[1][0] * pixel[0] + m[1][1] * pixel[1] + m[1][2] * pixel[2],
            None => pixel[1],
        }
    }

    /// The same for whole scanlines, appended to `luminances`.
    pub fn luminances_cd_m2(&self, data: &[f32], ncomp: usize, luminances: &mut Vec<f32>) {
        match (ncomp, &self.undo) {
            (3, None) => luminances.extend(data.as_chunks::<3>().0.iter().map(|p| p[1])),
            _ => luminances.extend(data.chunks_exact(ncomp).map(|p| self.luminance_cd_m2(p))),
        }
    }

    /// Luminance seen, cd/m2, and the XYZ that is shown for it.
    #[inline(always)]
    pub fn sees(&self, pixel: &[f32]) -> (f32, [f32; 3]) {
        let xyz = [pixel[0], pixel[1], pixel[2]];
        let shown = self.adapt.map_or(xyz, |m| matrix::multiply(&m, xyz));
        if !self.rods {
            return (self.luminance_cd_m2(pixel), shown);
        }
        let y = self.luminance_cd_m2(pixel);
        let cones = cone_share(y);
        if cones >= 1.0 {
            return (y, shown);
        }
        let v = self.scotopic(pixel);
        let rods = (1.0 - cones) * v / WHITE_SCOTOPIC;
        (cones * y + rods, std::array::from_fn(|i| cones * shown[i] + rods * self.grey[i]))
    }

    /// The same for a group of XYZ, in planes.
    #[inline(always)]
    pub fn sees_group(&self, xyz: &[[f32; GROUP]; 3]) -> ([f32; GROUP], [[f32; GROUP]; 3]) {
        let mut shown = self.adapt.map_or(*xyz, |m| matrix::multiply_planes(&m, xyz));
        let mut seen = match &self.undo {
            Some(m) => matrix::multiply_planes(m, xyz)[1],
            None => xyz[1],
        };
        // By day, cones see alone.
        if !self.rods || seen.iter().fold(true, |day, y| day & (cone_share(*y) >= 1.0)) {
            return (seen, shown);
        }
        let received = self.undo.map_or(*xyz, |m| matrix::multiply_planes(&m, xyz));
        for i in 0..GROUP {
            let y = seen[i];
            let cones = cone_share(y);
            let v = mesopic::scotopic([received[0][i], received[1][i], received[2][i]]);
            let (day, rods) = (cones >= 1.0, (1.0 - cones) * v / WHITE_SCOTOPIC);
            seen[i] = if day { y } else { cones * y + rods };
            for (plane, grey) in shown.iter_mut().zip(self.grey) {
                plane[i] = if day { plane[i] } else { cones * plane[i] + rods * grey };
            }
        }
        (seen, shown)
    }

    /// Nothing stands between a picture's XYZ and what is shown.
    pub fn is_plain(&self) -> bool {
        self.undo.is_none() && self.adapt.is_none() && !self.rods
    }
}

/// Undoes the adaptation that a header notes.
fn undoing(a: &Adapted) -> Result<Mat3> {
    let unknown = |_| Error::Invalid(format!("ADAPTED: no adaptation is named '{}'", printable(a.cat.as_bytes())));
    let cat = <Cat as clap::ValueEnum>::from_str(&a.cat, true).map_err(unknown)?;
    let done = adapt::von_kries(cat, a.from, a.to, a.degree)?;
    done.inverse().ok_or_else(|| Error::Invalid("ADAPTED: the adaptation has no inverse".into()))
}

/// A spectrum as XYZ and scotopic luminance, 1700 lm/W by V'(lambda).
fn with_scotopic(input: Box<dyn Picture>) -> Result<Box<dyn Picture>> {
    let rods = builtin::spectrum("scotopic_v")?;
    let missing = || Error::Invalid("the picture lists no wavelengths".into());
    let sampling = input.header().sampling.clone().ok_or_else(missing)?;
    let [x, y, z] = weights(input.header(), &Observer::cie1931()?)?;
    let v = sampling.response_weights(&rods).iter().map(|w| SCOTOPIC_EFFICACY * w).collect();
    let mut header = input.header().clone();
    header.become_tristimulus(Components::Response, Units::CdM2);
    integrated(input, header, &[x, y, z, v])
}
