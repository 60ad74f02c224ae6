//! plocal: local tone mapping, technique D of [Ward 2001]: base and detail, or a multi-scale retinex (see `tone::local`).
//!
//! Colour is kept in xy, all of XYZ times the display luminance over the world's; or, with an exponent S, in linear RGB of
//! BT.709 as [Durand 2002] and its followers do, C' = (C / L)^S L' for each component C, and all three scaled so that the
//! luminance is L' again. A negative component keeps its sign; a colour so far out that its power has no luminance keeps its xy.

use std::fmt;
use std::str::FromStr;
use std::sync::{Mutex, PoisonError};

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::{Primaries, matrix};
use crate::display as medium;
use crate::filter::{Filter, Product, Run};
use crate::options::Size;
use crate::parallel;
use crate::stream::{Block, Components, Header, Picture, Units, picture, spool, tristimulus};
use crate::tone::Display;
use crate::tone::local::{self, Amount, Limited, Luminances, Mapped};
use crate::view::View;
use crate::{Error, Result, invalid, string_serde, usage};

/// How a picture is split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[value(rename_all = "kebab-case")]
pub enum Method {
    /// Compress an edge-preserving base, keep the detail
    BaseDetail,
    /// Keep what stands out from three blurred surrounds; halos are wide
    Retinex,
}

/// Options of `plocal`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Plocal {
    /// Display to map for, by name or file: its black and white, ambient light included
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath, conflicts_with_all = ["ldmax", "lddyn"])]
    pub display: Option<medium::Display>,
    /// Luminance of the display's white, cd/m2
    #[arg(short = 'u', long, value_name = "CD_M2", default_value_t = 100.0)]
    pub ldmax: f64,
    /// Contrast of the display: white over black
    #[arg(short = 'd', long, value_name = "RATIO", default_value_t = 100.0)]
    pub lddyn: f64,
    /// How the picture is split
    #[arg(long, value_enum, value_name = "METHOD", default_value = "base-detail")]
    pub method: Method,
    /// What is smaller than this is detail: a share of the picture's long side, or degrees of its VIEW, such as 1deg; 0.02 if
    /// absent, with retinex 0.15
    #[arg(long, value_name = "SIZE")]
    pub scale: Option<Scale>,
    /// With base-detail: steps of luminance well under this ratio are detail, steps well over it edges
    #[arg(long, value_name = "RATIO", default_value_t = 1.4)]
    pub edge: f64,
    /// How much of the local map: 0 is one factor for all pixels, 1 all of the method
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    pub strength: f64,
    /// Contrast of the detail, as an exponent: 1 keeps it
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub detail: f64,
    /// Exponent of colours over their luminance, in linear BT.709: under 1 paler, over 1 stronger; 1 keeps xy
    #[arg(long, value_name = "EXPONENT", default_value_t = 1.0)]
    pub saturation: f64,
}
clap_defaults!(Plocal);

/// A length in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scale {
    /// Share of the long side.
    Share(f64),
    /// Degrees of the view, at its centre.
    Degrees(f64),
}

impl FromStr for Scale {
    type Err = Error;
    fn from_str(s: &str) -> Result<Scale> {
        let number = |t: &str, most: f64| t.trim().parse().ok().filter(|x| *x > 0.0 && *x <= most);
        let scale = match s.strip_suffix("deg") {
            Some(degrees) => number(degrees, 360.0).map(Scale::Degrees),
            None => number(s, 1.0).map(Scale::Share),
        };
        scale.ok_or_else(|| {
            Error::Invalid(format!("'{s}' is no size; give a share of the long side up to 1, or degrees such as 1deg"))
        })
    }
}

impl fmt::Display for Scale {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Scale::Share(x) => write!(f, "{x}"),
            Scale::Degrees(x) => write!(f, "{x}deg"),
        }
    }
}
string_serde!(Scale);

impl Scale {
    /// In pixels of this picture.
    fn pixels(self, header: &Header) -> Result<f64> {
        let r = header.resolution;
        match self {
            Scale::Share(share) => Ok(share * r.width.max(r.height) as f64),
            Scale::Degrees(degrees) => match View::of(header) {
                Some(view) => Ok(degrees.to_radians() * r.width as f64 / view.extent().0),
                None => invalid!("no VIEW line with an angle of view; give --scale as a share of the long side"),
            },
        }
    }
}

impl Plocal {
    fn range(&self) -> Result<Display> {
        super::display_range(self.display.as_ref(), self.ldmax, self.lddyn)
    }

    fn amount(&self) -> Result<Amount> {
        let within = |option: &str, x: f64, most: f64| match x {
            x if (0.0..=most).contains(&x) => Ok(()),
            _ => usage!("{option} {x} lies outside 0 to {most}"),
        };
        within("--strength", self.strength, 1.0)?;
        within("--detail", self.detail, 10.0)?;
        within("--saturation", self.saturation, 10.0)?;
        Ok(Amount { strength: self.strength, detail: self.detail })
    }

    fn method(&self, header: &Header) -> Result<local::Method> {
        let scale = |default| self.scale.unwrap_or(Scale::Share(default)).pixels(header);
        match self.method {
            Method::BaseDetail if !(self.edge > 1.0 && self.edge <= 1e6) => {
                usage!("--edge {} is no ratio of luminances over 1", self.edge)
            }
            Method::BaseDetail => {
                Ok(local::Method::BaseDetail { radius: (scale(0.02)?.round() as usize).max(1), edge: self.edge.ln() })
            }
            Method::Retinex if self.edge != Plocal::default().edge => usage!("--edge goes with --method base-detail"),
            Method::Retinex => Ok(local::Method::Retinex { scale: scale(0.15)?.max(1.0) }),
        }
    }
}

/// What a colour becomes.
#[derive(Clone, Copy)]
enum Colour {
    Kept,
    Exponent { exponent: f32, rgb: [[f32; 3]; 3], xyz: [[f32; 3]; 3] },
}

impl Colour {
    fn new(exponent: f64) -> Colour {
        let p = Primaries::BT709;
        match (p.from_xyz(), p.to_xyz()) {
            (Some(rgb), Some(xyz)) if exponent != 1.0 => {
                Colour::Exponent { exponent: exponent as f32, rgb: rgb.to_f32(), xyz: xyz.to_f32() }
            }
            _ => Colour::Kept,
        }
    }

    /// The pixel with luminance `share` in place of its own, which is above 0.
    fn apply(&self, pixel: &mut [f32], share: f32) {
        let mut relative = [pixel[0] / pixel[1], 1.0, pixel[2] / pixel[1]];
        if let Colour::Exponent { exponent, rgb, xyz } = self {
            let power = matrix::multiply(rgb, relative).map(|c| c.abs().powf(*exponent).copysign(c));
            let [x, y, z] = matrix::multiply(xyz, power);
            if y > 1e-6 && (x / y).is_finite() && (z / y).is_finite() {
                relative = [x / y, 1.0, z / y];
            }
        }
        // A colour without luminance to speak of may be too large for a float over it.
        pixel.iter_mut().zip(relative).for_each(|(p, c)| *p = (c.clamp(f32::MIN, f32::MAX)) * share);
    }
}

/// What happens to every pixel.
struct Map {
    luminances: Mapped,
    colour: Colour,
}

/// The input under its map.
struct Toned {
    input: Box<dyn Picture>,
    header: Header,
    map: Map,
    pixel: usize,
    limited: Limited,
    run: Run,
}

/// Pixels whose display values are worked out together.
const PIECE: usize = 512;

impl Map {
    /// Maps whole pixels, the first of which is the picture's `first`.
    fn apply(&self, first: usize, pixels: &mut [f32]) -> Limited {
        let mut limited = Limited::default();
        let mut shares = [0f32; PIECE];
        for (i, part) in pixels.chunks_mut(3 * PIECE).enumerate() {
            let shares = &mut shares[..part.len() / 3];
            limited.add(self.luminances.shares(first + i * PIECE, shares));
            for (pixel, share) in part.chunks_exact_mut(3).zip(shares) {
                // What has no luminance, and what is no number, is black.
                if *share > 0.0 { self.colour.apply(pixel, *share) } else { pixel.fill(0.0) }
            }
        }
        limited
    }
}

impl Toned {
    fn remark(&self) {
        let pixels = self.header.resolution.width as f64 * self.header.resolution.height as f64;
        let share = |n: u64| format!("{n} pixels ({:.2} %)", 100.0 * n as f64 / pixels);
        let Limited { white, black } = self.limited;
        if white > 0 {
            self.run.notes.add(format!("{} over the display's white became white's luminance", share(white)));
        }
        if black > 0 {
            self.run.notes.add(format!("{} under the display's black became black", share(black)));
        }
    }
}

impl Picture for Toned {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, block: &mut Block) -> Result<bool> {
        let more = self.input.next(block)?;
        if !more {
            self.remark();
            return Ok(false);
        }
        let (all, map, pixel) = (Mutex::new(Limited::default()), &self.map, self.pixel);
        parallel::for_pieces(&mut block.data, 3, |first, piece| {
            let limited = map.apply(pixel + first, piece);
            all.lock().unwrap_or_else(PoisonError::into_inner).add(limited);
        });
        self.limited.add(all.into_inner().unwrap_or_else(PoisonError::into_inner));
        self.pixel += block.data.len() / 3;
        Ok(more)
    }
}

impl Filter for Plocal {
    const NAME: &'static str = "plocal";
    const ABOUT: &'static str =
        "Map luminance to a display locally: base and detail, or retinex (reads its input twice, or keeps it)";
    const EXAMPLE: &'static str =
        "vonkries --to D65 < scene.lux | plocal | xyz2rgb --gamut desaturate | ra_png > scene.png";

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        super::check_scene(input.header())?;
        let (display, amount) = (self.range()?, self.amount()?);
        let input = tristimulus(input)?;
        let method = self.method(input.header())?;
        let mut header = input.header().clone();
        header.become_tristimulus(Components::Xyz, Units::Display);
        header.display = Some([display.min_cd_m2, display.max_cd_m2]);
        let r = header.resolution;
        let (pixels, mut limits) = (r.width as u64 * r.height as u64, run.options.limits());
        let bytes = method.bytes(pixels);
        if bytes > limits.memory {
            return Err(Error::Unsupported(format!(
                "the luminances of {} x {} pixels at this scale take {}M, over --memory {}; give --memory {}M",
                r.width,
                r.height,
                bytes.div_ceil(1 << 20),
                Size(limits.memory),
                bytes.div_ceil(1 << 20),
            )));
        }
        limits.memory -= bytes;
        let mut seen = Luminances::new(r.scanline_len(), pixels as usize);
        let (mut odd, mut negative) = (0u64, 0u64);
        let input = spool::twice(input, &limits, &run.notes, |_, block| {
            for pixel in block.data.chunks_exact(3) {
                let finite = pixel.iter().all(|x| x.is_finite());
                odd += u64::from(!finite);
                negative += u64::from(finite && pixel[1] < 0.0);
            }
            seen.add(&block.data);
        })?;
        if odd > 0 {
            run.notes.add(format!("{odd} pixels with a component that is not finite became black"));
        }
        if negative > 0 {
            run.notes.add(format!("{negative} pixels with a negative luminance became black"));
        }
        let Some(luminances) = seen.mapped(method, amount, display) else {
            run.notes.add("the picture is black: nothing to map");
            return Ok(Product::Picture(picture::map(input, header, |pixels| pixels.fill(0.0))));
        };
        let (map, limited) = (Map { luminances, colour: Colour::new(self.saturation) }, Limited::default());
        Ok(Product::Picture(Box::new(Toned { input, header, map, pixel: 0, limited, run: run.clone() })))
    }
}
