//! falsecolor: luminance or illuminance as colours, with a legend (see `chart`).

use std::ffi::OsString;
use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::chart::legend::Legend;
use crate::chart::sheet;
use crate::chart::values::Values;
use crate::chart::{Map, Palette, Scale, Style};
use crate::codec::{self, Reading};
use crate::color::Primaries;
use crate::filter::{Filter, Product, Run};
use crate::options::Pair;
use crate::stream::meaning::Overrides;
use crate::stream::upright::upright;
use crate::stream::{Components, Picture, Units, luminance, reader, spool, tristimulus};
use crate::units::RADIANCE_EFFICACY;
use crate::{Error, Result, clap_defaults, usage};

/// Options of `falsecolor`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Falsecolor {
    /// What the picture holds: illuminance where rpict -i made it, whose numbers are lux as they stand
    #[arg(long, value_enum, value_name = "WHAT", default_value = "luminance")]
    pub quantity: Quantity,
    /// Value at the top of the scale; a round one above the largest, if absent or 'auto'
    #[arg(short, long, value_name = "MAX", default_value = "auto")]
    pub scale: Top,
    /// Value at the bottom of the scale: 0, or with --log that many decades below the top
    #[arg(long, value_name = "MIN", allow_hyphen_values = true)]
    pub min: Option<f64>,
    /// A logarithmic scale of so many decades
    #[arg(long, value_name = "DECADES")]
    pub log: Option<f64>,
    /// Multiply values, to show for instance daylight factors
    #[arg(long, value_name = "FACTOR", default_value_t = 1.0)]
    pub factor: f64,
    /// Colours: spec, viridis, inferno, hot, pm3d or grey
    #[arg(long, value_name = "NAME", default_value = "spec")]
    pub palette: Palette,
    /// Divisions of the scale: bands, contours, values in the legend
    #[arg(short = 'n', long, value_name = "N", default_value_t = 8)]
    pub divisions: usize,
    /// One colour a division
    #[arg(long, conflicts_with_all = ["contours", "contour_bands"])]
    pub bands: bool,
    /// Contour lines on black, or on --background
    #[arg(long, conflicts_with = "contour_bands")]
    pub contours: bool,
    /// Contours that are wide where values change little
    #[arg(long)]
    pub contour_bands: bool,
    /// Picture under the contours, shown linearly: a file, or 'input' for the picture itself
    #[arg(short = 'p', long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    #[serde(serialize_with = "crate::options::lossy")]
    pub background: Option<PathBuf>,
    /// Mark the smallest and the largest value
    #[arg(short, long)]
    pub extremes: bool,
    /// Unit above the legend, in place of the picture's
    #[arg(short, long, value_name = "TEXT")]
    pub label: Option<String>,
    /// Size of the legend in pixels; 0x0 for none; as large as the picture asks, if absent
    #[arg(long, value_name = "WxH")]
    pub legend: Option<Pair>,
}
clap_defaults!(Falsecolor);

/// What the picture holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// cd/m2
    Luminance,
    /// lux
    Illuminance,
}

/// The top of the scale.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Top {
    /// Chosen by the picture.
    Auto,
    /// Given.
    Value(f64),
}

impl std::str::FromStr for Top {
    type Err = Error;
    fn from_str(text: &str) -> Result<Top> {
        match text.parse() {
            Ok(x) if f64::is_finite(x) => Ok(Top::Value(x)),
            _ if text.starts_with('a') && "auto".starts_with(text) => Ok(Top::Auto),
            _ => Err(Error::Invalid(format!("'{text}': expected a value such as 1000, or 'auto'"))),
        }
    }
}

impl std::fmt::Display for Top {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Top::Auto => f.write_str("auto"),
            Top::Value(x) => write!(f, "{x}"),
        }
    }
}
crate::string_serde!(Top);

impl Falsecolor {
    fn check(&self) -> Result<()> {
        super::positive("--log", self.log)?;
        super::positive("--factor", Some(self.factor))?;
        if !(1..=100).contains(&self.divisions) {
            return usage!("--divisions {} must be 1 to 100", self.divisions);
        }
        if self.background.is_some() && !self.style().has_lines() {
            return usage!("--background goes with --contours or --contour-bands");
        }
        match self.log {
            Some(d) if d > 30.0 => usage!("--log {d} must be up to 30 decades"),
            _ => Ok(()),
        }
    }

    fn style(&self) -> Style {
        match (self.bands, self.contours, self.contour_bands) {
            (true, ..) => Style::Bands,
            (_, true, _) => Style::Contours,
            (.., true) => Style::ContourBands,
            _ => Style::Fill,
        }
    }

    fn unit(&self, units: Units) -> &str {
        match (&self.label, units, self.quantity) {
            (Some(label), ..) => label,
            (_, Units::CdM2, Quantity::Luminance) => "cd/m²",
            (_, Units::CdM2, Quantity::Illuminance) => "lux",
            _ => "",
        }
    }

    /// The picture that contours lie on.
    fn ground(&self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Option<Box<dyn Picture>>> {
        let (Some(path), limits) = (&self.background, run.options.limits()) else { return Ok(None) };
        let picture = match input {
            Some(input) => input,
            None => {
                let overrides = Overrides::default();
                let reading = Reading { overrides: &overrides, limits: &limits, notes: &run.notes };
                upright(codec::open(reader::Input::open(Some(path))?, &reading)?, &limits)?
            }
        };
        sheet::shown_linearly(picture, &limits, &run.notes).map(Some)
    }
}

impl Filter for Falsecolor {
    const NAME: &'static str = "falsecolor";
    const ABOUT: &'static str = "Show luminance or illuminance as colours, bands or contours, with a legend; what is negative or no number is magenta";
    const EXAMPLE: &'static str = "falsecolor --log 3 --extremes scene.lux | ra_png > map.png\nfalsecolor --contours --background input -n 10 scene.lux | ra_png > contours.png";

    fn rewrite(args: Vec<OsString>) -> Result<Vec<OsString>> {
        radiance_words(args)
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        self.check()?;
        let limits = run.options.limits();
        let mut header = input.header().clone();
        let unit = self.unit(header.units).to_string();
        let on_itself = self.background.as_ref().is_some_and(|b| b.as_os_str() == "input");
        let input = upright(input, &limits)?;
        let mut values = Values::new(&header, self.factor, limits.memory)?;
        let kept = if on_itself {
            let n = if input.header().components == Components::Y { 1 } else { 3 };
            let input = if n == 1 { input } else { tristimulus(input)? };
            Some(spool::twice(input, &limits, &run.notes, |_, block| values.add(&block.data, n))?)
        } else {
            values.add_all(luminance(input)?)?;
            None
        };
        let ground = self.ground(kept, run)?;
        let top = match self.scale {
            Top::Auto => None,
            Top::Value(x) => Some(x),
        };
        let scale = Scale::chosen(top, self.min, self.log, self.divisions, values.largest())?;
        let (magenta, marks) =
            (values.without_value(scale.min), if self.extremes { values.extremes() } else { vec![] });
        if magenta > 0 {
            run.notes.add(format!("{magenta} pixels that are negative or not finite are magenta"));
        }
        let size = sheet::point_size(values.height());
        let legend = Legend { scale: &scale, palette: &self.palette, style: self.style(), unit: &unit };
        let legend = legend.sized(self.legend.map(|p| (p.0, p.1)), values.height(), size, limits.memory)?;
        let (width, values) = values.take();
        let line = 0.75 + 0.75 * size as f32;
        let map = Map::new(width, values, &scale, self.palette.clone(), self.style(), line);
        header.become_tristimulus(Components::Rgb, Units::Display);
        header.primaries = Some(Primaries::BT709);
        sheet::Sheet::new(header, map, ground, legend, &marks, size).map(|s| Product::Picture(Box::new(s)))
    }
}

/// Radiance's command line in today's words: `-i` and `-ip` name the input, options of several letters have two dashes.
fn radiance_words(args: Vec<OsString>) -> Result<Vec<OsString>> {
    let mut words = Vec::new();
    let (mut input, mut legend) = (None, [None, None]);
    let mut args = args.into_iter();
    while let Some(word) = args.next() {
        let text = word.to_string_lossy().into_owned();
        let mut next = || args.next().ok_or_else(|| Error::Usage(format!("{text} needs a value")));
        match text.as_str() {
            "-i" => input = Some(next()?),
            "-ip" | "-pi" => {
                words.push("--background=input".into());
                input = Some(next()?);
            }
            "-cl" => words.push("--contours".into()),
            "-cb" => words.push("--contour-bands".into()),
            "-cp" => words.push("--bands".into()),
            "-log" | "-pal" => {
                words.push(if text == "-log" { "--log".into() } else { "--palette".into() });
                words.push(next()?);
            }
            "-lw" => legend[0] = Some(next()?),
            "-lh" => legend[1] = Some(next()?),
            "-m" => {
                let value = next()?;
                let number: Option<f64> = value.to_str().and_then(|v| v.parse().ok());
                let number = number.ok_or_else(|| Error::Usage("-m needs a number, 179 for cd/m2".into()))?;
                words.push(format!("--factor={}", number / RADIANCE_EFFICACY).into());
            }
            _ => words.push(word),
        }
    }
    if legend.iter().any(Option::is_some) {
        // Radiance's legend has 100 x 200 pixels.
        let [w, h] = legend.map(|n| n.map(|n| n.to_string_lossy().into_owned()));
        words.push(format!("--legend={}x{}", w.unwrap_or("100".into()), h.unwrap_or("200".into())).into());
    }
    words.extend(input);
    Ok(words)
}
