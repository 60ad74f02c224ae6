//! pcond: map world luminance to what a display can show: technique C of [Ward 2001] and its kin, one for each goal.
//!
//! What the eye does comes first (`-a` acuity, `-v` veil, `-c` rods), then a curve of luminance that the picture's histogram
//! decides ([`rule`]), last the device (`-p`, `-f`). See docs/tone.md.

mod arguments;
mod eye;
mod look;
mod pixels;
mod rule;

use std::ffi::OsString;
use std::fmt::{self, Write as _};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::color::{Primaries, White, Xy};
use crate::display as medium;
use crate::display::macbeth::Correction;
use crate::filter::{Filter, Product, Run};
use crate::options::ReadOptions;
use crate::stream::output::Output;
use crate::stream::{Picture, spool};
use crate::tone::fovea::{Attention, Cells, Field};
use crate::tone::veil::Scatter;
use crate::tone::{Curve, Display, Histogram, Scale, acuity, adjust};
use crate::units::RADIANCE_EFFICACY;
use crate::{Error, Result, clap_defaults, string_serde, usage};

pub use arguments::rewrite;
use eye::Eye;
pub use look::histogram;
use look::{First, Seen};
use pixels::Factor;
use rule::Rule;
pub use rule::{Goal, Surround};

/// How light scatters in the eye.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Glare {
    /// A share of 0.087 of what the eye is adapted to [Ward 1997]
    Ward,
    /// The CIE's general equation, by age [CIE 146]
    Cie,
}

/// Options of `pcond`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pcond {
    /// Display to map for, by name or file: its black and white, ambient light included
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath, conflicts_with_all = ["ldmax", "lddyn"])]
    pub display: Option<medium::Display>,
    /// Luminance of the display's white, cd/m2 (-u)
    #[arg(short = 'u', long, value_name = "CD_M2", default_value_t = 100.0)]
    pub ldmax: f64,
    /// Contrast of the display: white over black (-d)
    #[arg(short = 'd', long, value_name = "RATIO", default_value_t = 100.0)]
    pub lddyn: f64,
    /// What a person would see: acuity, veil, sensitivity and mesopic colour together, and the goal is visibility (-h)
    #[arg(long)]
    pub human: bool,
    /// Blur what is too dark to be seen sharp (-a); =false leaves it out of --human
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true)]
    pub acuity: Option<bool>,
    /// Add the light that scatters in the eye (-v)
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true)]
    pub veil: Option<bool>,
    /// Count contrast in thresholds of the eye instead of ratios (-s)
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true)]
    pub sensitivity: Option<bool>,
    /// Lose colour in the dark, where rods see (-c)
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true", require_equals = true)]
    pub mesopic: Option<bool>,
    /// What to keep; contrast unless --human asks for visibility
    #[arg(long, value_enum, value_name = "GOAL")]
    pub goal: Option<Goal>,
    /// As Radiance's pcond: its stop rule, its range of 1e-7 to 1e7 cd/m2, its glare of 0.08
    #[arg(long, conflicts_with = "goal")]
    pub classic: bool,
    /// For a print: most contrast under the veil of its gloss, colours darkened rather than paled
    #[arg(long, conflicts_with_all = ["goal", "classic", "linear", "exposure", "human", "sensitivity"])]
    pub print: bool,
    /// With --print: density of the paper
    #[arg(long, value_name = "DENSITY", default_value_t = 0.06, requires = "print", conflicts_with = "display")]
    pub dmin: f64,
    /// With --print: largest density
    #[arg(long, value_name = "DENSITY", default_value_t = 2.1, requires = "print", conflicts_with = "display")]
    pub dmax: f64,
    /// With --print: share of the light on it that its gloss reflects into the eye; --ldmax is a perfect white there
    #[arg(long, value_name = "SHARE", default_value_t = 0.006, requires = "print", conflicts_with = "display")]
    pub gloss: f64,
    /// With --veil: how light scatters
    #[arg(long, value_enum, value_name = "MODEL", default_value = "ward")]
    pub glare: Glare,
    /// With --glare cie: years
    #[arg(long, value_name = "YEARS", default_value_t = 35.0)]
    pub age: f64,
    /// With --glare cie: 0 black eyes, 0.5 brown, 1 light, 1.2 very light
    #[arg(long, value_name = "P", default_value_t = 0.5)]
    pub pigmentation: f64,
    /// With -s or -h: eyes come from a place of this luminance, cd/m2, and have not yet adapted to a darker one
    #[arg(long, value_name = "CD_M2")]
    pub adapted: Option<f64>,
    /// With --goal colour: luminance of the scene's white, cd/m2; otherwise the 99th percentile
    #[arg(long, value_name = "CD_M2")]
    pub white_luminance: Option<f64>,
    /// Change the white first, from that of the header or --white to this one, as vonkries would. --white alone changes it to the
    /// display's
    #[arg(long, value_name = "WHITE")]
    pub to_white: Option<White>,
    /// Surround of the display: exponent 1, 1.25 or 1.5 on its share of white, xy kept
    #[arg(long, value_enum, value_name = "SURROUND", default_value = "average")]
    pub surround: Surround,
    /// Weigh the middle of the view more (-w)
    #[arg(long)]
    pub centre: bool,
    /// Share of the weight, 0 to 1, that places in --fixations have (-i)
    #[arg(short = 'i', long, value_name = "SHARE", default_value_t = 0.0, conflicts_with = "histogram")]
    pub fixated: f64,
    /// Pixels that are looked at, a line each, x and y from the lower left corner; '-' is standard input
    #[arg(long, value_name = "FILE", default_value = "-", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "crate::options::lossy_path")]
    pub fixations: PathBuf,
    /// Take the histogram from FILE, as picinfo --histogram prints it, so that pictures share a map; '-' (-I) is standard input
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "crate::options::lossy")]
    pub histogram: Option<PathBuf>,
    /// Map of the frame before, from --map: this one departs from it by no more than --rate
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "crate::options::lossy")]
    pub previous: Option<PathBuf>,
    /// With --previous: stops of display luminance that a frame may change
    #[arg(long, value_name = "STOPS", default_value_t = 0.1)]
    pub rate: f64,
    /// One factor for all pixels, from the mean of log luminance; a scene that fits the display is shifted until all of it
    /// shows (-l)
    #[arg(long, conflicts_with_all = ["exposure", "goal"])]
    pub linear: bool,
    /// One given factor for all pixels, in Radiance's sense (179 cd/m2 becomes white at 1), or with a sign in stops (-e)
    #[arg(short = 'e', long, value_name = "FACTOR", allow_hyphen_values = true)]
    pub exposure: Option<Stops>,
    /// Write RGB of these primaries, eight numbers or a name, the white changed to theirs (-p)
    #[arg(long, value_name = "PRIMARIES")]
    pub to: Option<Primaries>,
    /// Write RGB corrected for a device by a .cal file of Radiance's macbethcal -c (-f)
    #[arg(short = 'f', long, value_name = "FILE", value_hint = ValueHint::FilePath, conflicts_with = "to")]
    #[serde(serialize_with = "crate::options::lossy")]
    pub calibration: Option<PathBuf>,
    /// Write the map to FILE: 100 lines of world and display luminance, cd/m2 (-x)
    #[arg(short = 'x', long, value_name = "FILE", value_hint = ValueHint::AnyPath)]
    #[serde(serialize_with = "crate::options::lossy")]
    pub map: Option<PathBuf>,
    /// `--white` was given on the command line: set as the stage is placed.
    #[arg(skip)]
    #[serde(skip)]
    pub white_given: bool,
}
clap_defaults!(Pcond);

/// An exposure as Radiance's filters take it, with its spelling.
#[derive(Clone, Debug, PartialEq)]
pub struct Stops {
    text: String,
    factor: f64,
}

impl FromStr for Stops {
    type Err = Error;
    fn from_str(text: &str) -> Result<Stops> {
        let number: Option<f64> = text.parse().ok().filter(|x: &f64| x.is_finite());
        let factor = number.map(|n| if text.starts_with(['+', '-']) { n.exp2() } else { n });
        match factor.filter(|f| (1e-30..1e30).contains(f)) {
            Some(factor) => Ok(Stops { text: text.to_string(), factor }),
            None => Err(Error::Invalid(format!("'{text}': expected a factor such as 0.5, or stops such as -1 or +2"))),
        }
    }
}

impl fmt::Display for Stops {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)
    }
}
string_serde!(Stops);

/// Lines of a map file.
const MAP_LINES: usize = 100;

impl Pcond {
    fn on(&self, switch: Option<bool>) -> bool {
        switch.unwrap_or(self.human)
    }

    fn check(&self) -> Result<()> {
        let within = |option: &str, x: f64, low: f64, high: f64| {
            if (low..=high).contains(&x) { Ok(()) } else { usage!("--{option} {x} must be {low} to {high}") }
        };
        within("age", self.age, 1.0, 120.0)?;
        within("pigmentation", self.pigmentation, 0.0, 1.2)?;
        within("fixated", self.fixated, 0.0, 1.0)?;
        within("rate", self.rate, 0.0, 1000.0)?;
        super::positive("--adapted", self.adapted)?;
        super::positive("--white-luminance", self.white_luminance)?;
        let goal = self.goal();
        let default = Pcond::default();
        let visibility = self.on(self.sensitivity) || goal == Goal::Visibility;
        if self.adapted.is_some() && (!visibility || self.classic || goal == Goal::Colour) {
            return usage!("--adapted goes with -s, -h or --goal visibility");
        }
        if self.white_luminance.is_some() && goal != Goal::Colour {
            return usage!("--white-luminance goes with --goal colour");
        }
        if (self.age, self.pigmentation) != (default.age, default.pigmentation) && self.glare != Glare::Cie {
            return usage!("--age and --pigmentation go with --glare cie");
        }
        if self.glare == Glare::Cie && (!self.on(self.veil) || self.classic) {
            return usage!("--glare cie goes with -v or -h, and not with --classic");
        }
        if self.exposure.is_some() && (self.map.is_some() || self.previous.is_some() || self.histogram.is_some()) {
            return usage!(
                "--map, --previous and --histogram go with a map that the picture decides, not with --exposure"
            );
        }
        if self.map.as_deref() == Some(Path::new("-")) {
            return usage!("--map needs a file: standard output carries the picture");
        }
        Ok(())
    }

    fn goal(&self) -> Goal {
        let visible = self.human && !self.classic && !self.print && self.on(self.sensitivity);
        self.goal.unwrap_or(if visible { Goal::Visibility } else { Goal::Contrast })
    }

    fn range(&self) -> Result<Display> {
        if self.print && self.display.is_none() {
            let (dmin, dmax, gloss) = (self.dmin, self.dmax, self.gloss);
            if !(dmin >= 0.0 && dmin < dmax && dmax <= 6.0 && (0.0..1.0).contains(&gloss)) {
                return usage!(
                    "--dmin {dmin}, --dmax {dmax}, --gloss {gloss}: expected 0 <= dmin < dmax <= 6, gloss 0 to 1"
                );
            }
            let seen = |density: f64| self.ldmax * (10f64.powf(-density) + gloss);
            return Ok(Display { max_cd_m2: seen(dmin), min_cd_m2: seen(dmax) });
        }
        super::display_range(self.display.as_ref(), self.ldmax, self.lddyn)
    }

    /// The primaries that colours have to fit.
    fn primaries(&self) -> Primaries {
        self.to.or(self.display.as_ref().map(|d| d.primaries)).unwrap_or(Primaries::BT709)
    }

    /// The white the picture is to be shown with, if it is to be changed.
    fn shown_white(&self) -> Result<Option<Xy>> {
        match &self.to_white {
            Some(white) => match white.xy() {
                Some(xy) => Ok(Some(xy)),
                None => usage!("--to-white {white}: expected x,y, an illuminant or a temperature"),
            },
            None => Ok(self.white_given.then(|| self.display.as_ref().map_or(Xy::D65, |d| d.primaries.white))),
        }
    }

    fn rule(&self) -> Rule {
        let sensitivity = self.on(self.sensitivity);
        if self.linear {
            Rule::Linear
        } else if self.print {
            Rule::Print(self.primaries())
        } else if self.classic {
            Rule::Classic(sensitivity)
        } else {
            let adapted = self.adapted.unwrap_or(0.0);
            Rule::of(self.goal(), sensitivity, adapted, self.primaries(), self.white_luminance)
        }
    }

    fn scatter(&self) -> Scatter {
        match self.glare {
            _ if self.classic => Scatter::Classic,
            Glare::Ward => Scatter::Ward,
            Glare::Cie => Scatter::Cie { age: self.age, pigmentation: self.pigmentation },
        }
    }

    /// Writes `--map`, whole or not at all: the display's luminance, cd/m2, for even steps of the world's logarithm.
    fn write_map(&self, shown_cd_m2: impl Fn(f64) -> f64, range_cd_m2: (f64, f64)) -> Result<()> {
        let Some(path) = self.map.as_ref() else { return Ok(()) };
        let (low, high) = (range_cd_m2.0.ln(), range_cd_m2.1.ln());
        let mut text = String::new();
        for i in 0..MAP_LINES {
            let world = (low + (high - low) * i as f64 / (MAP_LINES - 1) as f64).exp();
            let _ = writeln!(text, "{world:.6e} {:.6e}", shown_cd_m2(world));
        }
        let mut out = Output::create(Some(path), false)?;
        std::io::Write::write_all(&mut out, text.as_bytes()).map_err(|e| out.error(e))?;
        out.finish()
    }

    /// Reads the picture once for what the map and the eye need, and puts the veil over it.
    fn look(&self, input: Box<dyn Picture>, eye: &Eye, cells: &Arc<Cells>, run: &Run) -> Result<Seen> {
        let veil = self.on(self.veil).then(|| self.scatter());
        // Made for the first rows: what a header claims must not take memory before any has come.
        let (ncomp, colours) = (input.header().ncomp, self.rule().needs_palette());
        let (mut first, mut veil) = (None, veil);
        let mut made = || First::new(ncomp, cells, veil.take(), colours);
        let look = |_: &crate::stream::Header, block: &crate::stream::Block| {
            first.get_or_insert_with(&mut made).add(&block.data, eye)
        };
        let picture = spool::twice(input, &run.options.limits(), &run.notes, look)?;
        let first = first.unwrap_or_else(made);
        if first.lost > 0 {
            run.notes.add(format!("{} pixels with a luminance that is not finite became black", first.lost));
        }
        Ok(first.seen(picture, eye))
    }

    /// The map, and the range of world luminances it was made for.
    fn curve(&self, seen: &Seen, cells: &Cells, display: Display, run: &Run) -> Result<Option<(Curve, Histogram)>> {
        let resolution = seen.picture.header().resolution;
        let histogram = match &self.histogram {
            Some(path) => rule::read_histogram(path)?,
            None => {
                let fixations = if self.fixated > 0.0 {
                    rule::read_fixations(&self.fixations, resolution.width, resolution.height)?
                } else {
                    Vec::new()
                };
                let attention = Attention { centre: self.centre, fixations, fixated: self.fixated };
                attention.histogram(cells, &seen.cells_cd_m2, &seen.pixels)
            }
        };
        if histogram.range_cd_m2().is_none() {
            run.notes.add("the picture is black: nothing to map");
            return Ok(None);
        }
        let mut curve = self.rule().map(&histogram, &seen.palette, display)?.with_contrast(self.surround.exponent());
        if let Some(path) = &self.previous {
            curve = curve.limited(&rule::read_map(path, display)?, self.rate * std::f64::consts::LN_2);
        }
        Ok(Some((curve, histogram)))
    }

    /// Acuity, the map, the device.
    fn show(
        &self,
        seen: Seen,
        eye: Eye,
        cells: Arc<Cells>,
        header: crate::stream::Header,
        factor: Factor,
    ) -> Result<Product> {
        let mut picture = seen.picture;
        if self.on(self.acuity) {
            let level = |i: usize| acuity::level(seen.cells_cd_m2[i], cells.pixels_a_degree(i));
            let levels: Vec<[f32; 1]> = (0..cells.count()).map(|i| [level(i) as f32]).collect();
            let highest = levels.iter().fold(0f32, |m, l| m.max(l[0]));
            if highest > 0.0 {
                picture = acuity::blurred(picture, Field::new(cells.clone(), levels), f64::from(highest));
            }
        }
        let fits = if self.print { self.primaries().from_xyz() } else { None };
        self.device(pixels::mapped(picture, header, eye, factor, fits))
    }

    fn device(&self, picture: Box<dyn Picture>) -> Result<Product> {
        if let Some(path) = &self.calibration {
            let shown = path.display().to_string();
            let text = crate::files::read_to_string(path).map_err(|e| Error::io(&shown, e))?;
            let correction = Correction::parse(&text).map_err(|e| e.within(&shown))?;
            return pixels::corrected(picture, correction).map(Product::Picture);
        }
        match self.to {
            Some(primaries) => pixels::device(picture, primaries).map(Product::Picture),
            None => Ok(Product::Picture(picture)),
        }
    }
}

impl Filter for Pcond {
    const NAME: &'static str = "pcond";
    const ABOUT: &'static str = "Map world luminance to a display: histogram adjustment, visibility, colour or print (reads its input twice, or keeps it). Radiance's own options work: -h -a -v -s -c -w -I -l with + and -, -i -e -u -d -p -f -x";
    const EXAMPLE: &'static str = "vonkries --to D65 < scene.lux | pcond | xyz2rgb --gamut desaturate | ra_png > scene.png\npcond -h+ -u 80 office.hdr --format rgbe > seen.hdr";

    fn rewrite(args: Vec<OsString>) -> Result<Vec<OsString>> {
        rewrite(args)
    }

    fn placed(&mut self, read: &ReadOptions, _: Option<&Path>) -> Result<()> {
        self.white_given = read.white.is_some();
        let standard = |p: &Path| p == Path::new("-");
        let takes = [
            (self.histogram.as_deref().is_some_and(standard), "the histogram (-I)"),
            (self.fixated > 0.0 && standard(&self.fixations), "the fixations (-i)"),
        ];
        match (takes.iter().find(|t| t.0), read.input.as_deref().is_none_or(standard)) {
            (Some((_, what)), true) => usage!("{what} comes from standard input, so the picture must be a file"),
            _ => Ok(()),
        }
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        super::check_scene(input.header())?;
        self.check()?;
        let display = self.range()?;
        let (eye, input, mut header) = Eye::of(input, self.shown_white()?, self.on(self.mesopic))?;
        header.display = Some([display.min_cd_m2, display.max_cd_m2]);
        let (cells, assumed) = Cells::of(input.header());
        let decides = self.exposure.is_none() && self.histogram.is_none();
        let looks = decides || self.on(self.veil) || self.on(self.acuity) || self.rule().needs_palette();
        if assumed && looks {
            run.notes.add("no VIEW line with an angle of view: taking 40 degrees on the long side");
        }
        let seen = if looks { self.look(input, &eye, &cells, run)? } else { Seen::nothing(input) };
        let contrast = self.surround.exponent();
        if let Some(stops) = &self.exposure {
            let factor = stops.factor / RADIANCE_EFFICACY;
            header.lines.push(format!("MAPPED_EXPOSURE={:.4e}", stops.factor).into_bytes());
            let curve = Curve::linear(factor * display.max_cd_m2, display).with_contrast(contrast);
            let factor = if contrast == 1.0 { Factor::Fixed(factor as f32) } else { Factor::Table(curve.table()) };
            return self.show(seen, eye, cells, header, factor);
        }
        let Some((curve, histogram)) = self.curve(&seen, &cells, display, run)? else {
            self.write_map(|_| display.min_cd_m2, (display.min_cd_m2, display.max_cd_m2))?;
            return self.show(seen, eye, cells, header, Factor::Fixed(0.0));
        };
        let range = histogram.range_cd_m2().unwrap_or((display.min_cd_m2, display.max_cd_m2));
        let factor = if self.linear && contrast == 1.0 && self.previous.is_none() {
            let factor = adjust::exposure(&histogram, display, &Scale::Ratio).exp() / display.max_cd_m2;
            header.lines.push(format!("MAPPED_EXPOSURE={:.4e}", factor * RADIANCE_EFFICACY).into_bytes());
            // A linear operator has no black of its own: what the display shows is its black and the picture's light.
            let over_black = |world: f64| (factor * world).min(1.0) * (display.max_cd_m2 - display.min_cd_m2);
            self.write_map(|world| display.min_cd_m2 + over_black(world), range)?;
            Factor::Fixed(factor as f32)
        } else {
            self.write_map(|world| curve.at(world), range)?;
            Factor::Table(curve.table())
        };
        self.show(seen, eye, cells, header, factor)
    }
}
