//! xyz2rgb: tristimulus values to linear RGB, Eq. (5) of [Ward 2001], and back; its gamut techniques A and B and the
//! rendering intents.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::compress::{Compressor, Curve, Hue};
use crate::color::gamut::{self, Gamut, Limit};
use crate::color::{Primaries, intent, matrix};
use crate::display::Display;
use crate::filter::{Filter, Product, Run};
use crate::stream::{Components, Header, Picture, Units, picture, spool, tristimulus};
use crate::{Error, Result, invalid, usage};

/// What has to fit into the gamut.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Reach {
    /// The most saturated colour of the picture (reads it twice)
    Image,
    /// Every visible colour
    Visible,
}

/// What a rendering is to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Intent {
    /// The stimulus in cd/m2, without adaptation or curve; outside the gamut the nearest in Delta E 2000 at equal luminance
    Colorimetric,
    /// Saturation in u'v', at the cost of luminance or hue
    Saturation,
    /// Appearance: after vonkries and pcond, technique B
    Perceptual,
}

/// Which matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Digits {
    /// From the primaries, in full
    Exact,
    /// Rounded to four decimals, as in the paper's time
    Rounded,
}

/// Options of `xyz2rgb`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Xyz2rgb {
    /// Primaries of the RGB: BT.709, P3, BT.2020, Adobe, Radiance, AP0, AP1, or eight numbers
    #[arg(long, value_name = "PRIMARIES", default_value = "BT.709")]
    pub to: Primaries,
    /// Display to show it on, by name or file: its primaries in place of --to
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath, conflicts_with = "to")]
    pub display: Option<Display>,
    /// What to do with colours that these primaries cannot make
    #[arg(long, value_enum, value_name = "HOW", default_value = "none")]
    pub gamut: Gamut,
    /// With shrink and compress: what has to fit
    #[arg(long, value_enum, value_name = "WHAT", default_value = "image")]
    pub reach: Reach,
    /// With compress: share of the gamut that stays as it is; 1 clips
    #[arg(long, value_name = "SHARE", default_value_t = 0.8)]
    pub knee: f64,
    /// With shrink and compress: where lines of constant hue are straight; the two part most for blues (docs/gamut.md)
    #[arg(long, value_enum, value_name = "SPACE", default_value = "uv")]
    pub hue: Hue,
    /// Rendering intent, in place of --gamut
    #[arg(long, value_enum, value_name = "INTENT", conflicts_with = "gamut")]
    pub intent: Option<Intent>,
    /// With colorimetric: scale luminance so that --white-luminance, or the brightest pixel, becomes the display's white
    #[arg(long)]
    pub relative: bool,
    /// With --relative: the scene's white, cd/m2
    #[arg(long, value_name = "CD_M2", requires = "relative")]
    pub white_luminance: Option<f64>,
    /// Digits of the matrix
    #[arg(long, value_enum, value_name = "DIGITS", default_value = "exact")]
    pub matrix: Digits,
    /// The other way: RGB to XYZ
    #[arg(short, long)]
    pub reverse: bool,
}
clap_defaults!(Xyz2rgb);

/// Whites further apart than this in x or y are worth a word.
const SAME_WHITE: f64 = 0.003;

impl Xyz2rgb {
    /// An option that would change nothing is a mistake.
    fn check(&self) -> Result<()> {
        let default = Xyz2rgb::default();
        let compress = self.gamut == Gamut::Compress || self.intent == Some(Intent::Perceptual);
        if self.knee != default.knee && !compress {
            return usage!("--knee goes with --gamut compress or --intent perceptual");
        }
        if (self.hue, self.reach) != (default.hue, default.reach) && !compress && self.gamut != Gamut::Shrink {
            return usage!("--hue and --reach go with --gamut shrink or compress, or --intent perceptual");
        }
        if self.relative && self.intent != Some(Intent::Colorimetric) {
            return usage!("--relative goes with --intent colorimetric");
        }
        Ok(())
    }

    fn primaries(&self) -> Primaries {
        self.display.as_ref().map_or(self.to, |d| d.primaries)
    }

    /// XYZ to RGB, and its luminance row.
    fn matrices(&self) -> Result<([[f32; 3]; 3], [f32; 3])> {
        let span = || Error::Usage("--to: these primaries span no area".into());
        let primaries = self.primaries();
        let m = match self.matrix {
            Digits::Exact => primaries.from_xyz(),
            Digits::Rounded => primaries.from_xyz_rounded(),
        };
        let y = primaries.to_xyz().ok_or_else(span)?.0[1].map(|x| x as f32);
        Ok((m.ok_or_else(span)?.to_f32(), y))
    }

    /// The header of the result; the stream's white and display are held against those asked for.
    fn header(&self, input: &Header, run: &Run) -> Result<Header> {
        let primaries = self.primaries();
        let mapped = input.display.filter(|_| input.units == Units::Display);
        if let (Some(display), Some(range)) = (&self.display, mapped) {
            display.check_range(range)?;
        }
        if let Some(white) = input.white.filter(|w| w.distance(primaries.white) > SAME_WHITE) {
            let message = format!(
                "the picture's white is {white}, that of {primaries} is {}; vonkries adapts, xyz2rgb does not",
                primaries.white
            );
            match self.intent {
                Some(Intent::Perceptual | Intent::Saturation) => return Err(Error::Invalid(message)),
                Some(Intent::Colorimetric) => {} // shows the stimulus, whatever the eye makes of it
                None => run.notes.add(message),
            }
        }
        let mut header = input.clone();
        header.become_tristimulus(Components::Rgb, input.units);
        header.primaries = Some(primaries);
        Ok(header)
    }

    /// Techniques A and B: bring saturations in, in XYZ.
    fn compressed(&self, input: Box<dyn Picture>, curve: Curve, run: &Run) -> Result<Box<dyn Picture>> {
        if !(0.0..=1.0).contains(&self.knee) {
            return usage!("--knee {} lies outside 0 to 1", self.knee);
        }
        let mut compressor = Compressor::new(self.primaries(), self.hue, curve)?;
        let visible = compressor.visible_reach()?;
        let mut input = input;
        compressor.reach = visible;
        if self.reach == Reach::Image {
            let mut reach = 1f64;
            input = spool::twice(input, &run.options.limits(), &run.notes, |_, block| {
                let excess = |p: &[f32]| compressor.excess([p[0], p[1], p[2]].map(f64::from));
                // Noise may lie beyond what can be seen; it does not set the scale.
                let most = block.data.chunks_exact(3).map(excess).fold(1.0, f64::max);
                reach = reach.max(most.min(visible));
            })?;
            compressor.reach = reach;
            if reach > 1.0005 {
                run.notes.add(format!("saturations reach {reach:.3} times the gamut"));
            }
        }
        let header = input.header().clone();
        Ok(picture::map_on_all_threads(input, header, move |pixels| {
            for p in pixels.chunks_exact_mut(3) {
                let out = compressor.apply([p[0], p[1], p[2]].map(f64::from));
                p.iter_mut().zip(out).for_each(|(p, x)| *p = (x as f32).clamp(f32::MIN, f32::MAX));
            }
        }))
    }

    /// The matrix, and what is left to do about the limits.
    fn converted(&self, input: Box<dyn Picture>, gamut: Gamut, run: &Run) -> Result<Box<dyn Picture>> {
        let (m, y) = self.matrices()?;
        let header = self.header(input.header(), run)?;
        let limit = if header.units == Units::CdM2 { Limit::Positive } else { Limit::Unit };
        let input = match gamut {
            Gamut::Shrink => self.compressed(input, Curve::Shrink, run)?,
            Gamut::Compress => self.compressed(input, Curve::Compress(self.knee), run)?,
            _ => input,
        };
        let (m, scale) = matrix::over_largest_sum(&m);
        let convert = move |pixels: &mut [f32]| {
            matrix::for_planes(
                pixels,
                #[inline(always)]
                |p| {
                    *p = matrix::multiply_planes(&m, p);
                    for plane in p.iter_mut() {
                        for x in plane {
                            *x *= scale;
                        }
                    }
                    if gamut != Gamut::None {
                        gamut::tame(p);
                    }
                    match gamut {
                        Gamut::None => {}
                        Gamut::Clip => gamut::clip(p, limit),
                        // After A and B only rounding and too much light remain.
                        Gamut::Desaturate | Gamut::Shrink | Gamut::Compress => gamut::desaturate(p, &y, limit),
                    }
                },
            )
        };
        Ok(picture::map(input, header, convert))
    }

    /// The stimulus itself on a display, in cd/m2.
    fn colorimetric(&self, input: Box<dyn Picture>, run: &Run) -> Result<Box<dyn Picture>> {
        if input.header().units != Units::CdM2 {
            return invalid!("the colorimetric intent shows cd/m2, the picture is {}", input.header().units);
        }
        let display = self.display.clone().map_or_else(|| "srgb".parse(), Ok)?;
        let gamut = intent::Gamut::new(display.primaries)?;
        let mut header = self.header(input.header(), run)?;
        header.primaries = Some(display.primaries);
        (header.units, header.display) = (Units::Display, Some(display.range()));
        let (input, scale) = self.scale(input, &display, run)?;
        let [black, white] = display.range();
        let neutral = display.primaries.white.xyz().map(|x| x * black);
        let unlike = Arc::new(AtomicU64::new(0));
        let counter = unlike.clone();
        let shown = picture::map_on_all_threads(input, header, move |pixels| {
            let mut count = 0;
            for p in pixels.chunks_exact_mut(3) {
                let light = [p[0], p[1], p[2]].map(|x| if x.is_finite() { f64::from(x) * scale } else { 0.0 });
                let over = [0, 1, 2].map(|i| (light[i] - neutral[i]) / (white - black));
                let rgb = gamut.nearest(over);
                count += u64::from(!gamut.is_exact(over));
                p.iter_mut().zip(rgb).for_each(|(p, x)| *p = x as f32);
            }
            counter.fetch_add(count, Ordering::Relaxed);
        });
        let (notes, name) = (run.notes.clone(), display.name.clone());
        Ok(picture::at_end(shown, move || {
            let count = unlike.load(Ordering::Relaxed);
            if count > 0 {
                notes.add(format!("{count} pixels are no stimulus that display {name} can show; they got the nearest"));
            }
        }))
    }

    /// The factor of `--relative`, and the picture ready to be read.
    fn scale(&self, input: Box<dyn Picture>, display: &Display, run: &Run) -> Result<(Box<dyn Picture>, f64)> {
        if !self.relative {
            return Ok((input, 1.0));
        }
        if let Some(white) = self.white_luminance {
            return match white {
                w if w > 0.0 && w.is_finite() => Ok((input, display.white_cd_m2 / w)),
                w => usage!("--white-luminance {w} must be above 0"),
            };
        }
        let mut most = 0f32;
        let input = spool::twice(input, &run.options.limits(), &run.notes, |_, block| {
            most = block.data.chunks_exact(3).map(|p| p[1]).filter(|y| y.is_finite()).fold(most, f32::max);
        })?;
        if most <= 0.0 {
            return invalid!("the picture is black: no white to scale to");
        }
        run.notes.add(format!("white is the brightest pixel, {most} cd/m2"));
        Ok((input, display.white_cd_m2 / f64::from(most)))
    }

    fn saturated(&self, input: Box<dyn Picture>, run: &Run) -> Result<Box<dyn Picture>> {
        let gamut = intent::Gamut::new(self.primaries())?;
        let header = self.header(input.header(), run)?;
        Ok(picture::map_on_all_threads(input, header, move |pixels| {
            for p in pixels.chunks_exact_mut(3) {
                let xyz = [p[0], p[1], p[2]].map(|x| if x.is_finite() { f64::from(x) } else { 0.0 });
                p.iter_mut().zip(gamut.as_saturated(xyz)).for_each(|(p, x)| *p = x as f32);
            }
        }))
    }
}

impl Filter for Xyz2rgb {
    const NAME: &'static str = "xyz2rgb";
    const ABOUT: &'static str = "Convert XYZ to linear RGB of any primaries, bring it into their gamut; -r goes back";
    const EXAMPLE: &'static str = "pcond < scene.lux | xyz2rgb --gamut desaturate | ra_png > scene.png\nxyz2rgb --intent colorimetric --display p3 < scene.lux | ra_png --display p3 > stimulus.png";

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.reverse {
            if input.header().components != Components::Rgb {
                return invalid!("-r expects RGB, the picture is {}", input.header().components);
            }
            return tristimulus(input).map(Product::Picture);
        }
        self.check()?;
        let input = tristimulus(input)?;
        let display_referred = input.header().units == Units::Display;
        let out = match self.intent {
            None => self.converted(input, self.gamut, run)?,
            Some(Intent::Colorimetric) => self.colorimetric(input, run)?,
            Some(_) if !display_referred => {
                return invalid!("this intent maps display-referred pictures; run vonkries and pcond first");
            }
            Some(Intent::Saturation) => self.saturated(input, run)?,
            Some(Intent::Perceptual) => self.converted(input, Gamut::Compress, run)?,
        };
        Ok(Product::Picture(out))
    }
}
