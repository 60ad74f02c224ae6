//! pplot: charts of tone curves, luminance histograms, spectra and tables, as SVG or PNG; Figures 6 to 8 of [Ward 2001].

use std::io::{Read as _, Write as _};
use std::path::Path;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::codec::Reading;
use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::options::Range;
use crate::plot::data::{self, Luminances, Table};
use crate::plot::{Axis, Bars, Chart, Scale, Series};
use crate::spectral::key::SpectrumKey;
use crate::spectral::{Spectrum, builtin, text};
use crate::stream::meaning::Overrides;
use crate::stream::output::Output;
use crate::stream::reader::Input;
use crate::stream::{Block, Picture, Units, tristimulus};
use crate::{Error, Result, clap_defaults, codec, invalid, usage};

/// Kinds of file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// Lines and text
    Svg,
    /// Pixels
    Png,
}

/// Options of `pplot`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pplot {
    /// Draw a tone curve as pcond -x writes it, lines of world and display luminance in cd/m2; once for each curve
    #[arg(long, value_name = "[NAME=]FILE")]
    pub curve: Vec<String>,
    /// Draw a luminance histogram behind the curves: of a picture, or ready as lines of log10 luminance and count; '-' is
    /// standard input
    #[arg(long, value_name = "FILE")]
    pub histogram: Option<String>,
    /// Draw a spectrum: a built-in name such as D65, or a file of lines wavelength_nm,value; once for each
    #[arg(long, value_name = "[NAME=]SPECTRUM", conflicts_with_all = ["curve", "histogram", "chart"])]
    pub spectrum: Vec<String>,
    /// Draw columns of a CSV file with a line of names; once for each file
    #[arg(long, value_name = "[NAME=]FILE", conflicts_with_all = ["curve", "histogram"])]
    pub chart: Vec<String>,
    /// Column of --chart that goes across; the first otherwise
    #[arg(long, value_name = "COLUMN", requires = "chart")]
    pub x: Option<String>,
    /// Column of --chart that goes up, once for each; the second otherwise
    #[arg(long, value_name = "COLUMN", requires = "chart")]
    pub y: Vec<String>,
    /// Column of --chart whose words part its rows into curves
    #[arg(long, value_name = "COLUMN", requires = "chart")]
    pub by: Option<String>,
    /// Close-up of tone curves at black: linear axes, from 0 to this world luminance
    #[arg(long, value_name = "CD_M2", conflicts_with_all = ["x_range", "spectrum", "chart", "log", "log_x", "log_y"])]
    pub zoom: Option<f64>,
    /// Display luminance that counts as 1; each curve's largest otherwise
    #[arg(long, value_name = "CD_M2", requires = "curve")]
    pub ldmax: Option<f64>,
    /// Logarithmic axes; tone curves have them anyway
    #[arg(long, conflicts_with_all = ["linear", "log_x", "log_y"])]
    pub log: bool,
    /// Logarithmic axis across
    #[arg(long, conflicts_with = "linear")]
    pub log_x: bool,
    /// Logarithmic axis upward
    #[arg(long, conflicts_with = "linear")]
    pub log_y: bool,
    /// Linear axes for tone curves
    #[arg(long)]
    pub linear: bool,
    /// Title above the chart
    #[arg(long, value_name = "TEXT")]
    pub title: Option<String>,
    /// Words at the axes in place of what they have: X,Y or X,Y,SECOND; an empty one stays
    #[arg(long, value_name = "LABELS")]
    pub labels: Option<String>,
    /// What to show across, in the axis' own unit
    #[arg(long, value_name = "A:B", allow_hyphen_values = true)]
    pub x_range: Option<Range>,
    /// What to show upward
    #[arg(long, value_name = "A:B", allow_hyphen_values = true)]
    pub y_range: Option<Range>,
    /// Width, pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 960)]
    pub width: u32,
    /// Height, pixels
    #[arg(long, value_name = "PIXELS", default_value_t = 640)]
    pub height: u32,
    /// Kind of file; by the suffix of OUTPUT otherwise, SVG on standard output
    #[arg(long, value_enum, value_name = "KIND")]
    pub kind: Option<Kind>,
}
clap_defaults!(Pplot);

/// No file of numbers is longer, bytes.
const LONGEST: u64 = 64 << 20;

impl Filter for Pplot {
    const NAME: &'static str = "pplot";
    const ABOUT: &'static str = "Draw tone curves, luminance histograms, spectra and tables as SVG or PNG; a picture's histogram when nothing is named";
    const EXAMPLE: &'static str = "pcond -x adjusted.map tests/data/radiance_office.hdr > /dev/null
pplot --curve adjusted.map --histogram tests/data/radiance_office.hdr curve.png
pplot --spectrum D65 --spectrum lamp=FL11 lamps.svg
pplot --chart tests/data/display_readings.csv --x g --y Y --log readings.svg
pplot < tests/data/radiance_office.hdr > histogram.svg";
    const READS: bool = false;
    const FORMATS: bool = false;
    const SIGNS: bool = false;

    /// Standard input is a picture when nothing is named.
    fn reads(&self) -> bool {
        self.histogram.is_none() && [&self.curve, &self.spectrum, &self.chart].iter().all(|list| list.is_empty())
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let mut chart = if !self.spectrum.is_empty() {
            self.spectra()?
        } else if !self.chart.is_empty() {
            self.table()?
        } else {
            self.tones(input, run)?
        };
        self.dress(&mut chart)?;
        let (sheet, remarks) = chart.draw(self.width, self.height)?;
        run.notes.extend(&remarks);
        let binary = self.kind == Some(Kind::Png);
        let write = Box::new(move |out: &mut Output| match self.kind.map_or_else(|| kind_of(out), Ok)? {
            Kind::Svg => out.write_all(sheet.svg().as_bytes()).map_err(|e| out.error(e)),
            Kind::Png => out.attempt(|out| sheet.png(out)),
        });
        Ok(Product::Bytes { binary, write })
    }
}

/// By the suffix of the file.
fn kind_of(out: &Output) -> Result<Kind> {
    match out.suffix().as_deref() {
        None => Ok(Kind::Svg),
        Some("svg") => Ok(Kind::Svg),
        Some("png") => Ok(Kind::Png),
        Some(other) => usage!("'.{}': expected .svg or .png, or --kind", printable(other.as_bytes())),
    }
}

/// NAME=FILE, or a file whose name without folder and suffix is its name.
fn named(word: &str) -> (String, &str) {
    match word.split_once('=') {
        Some((name, file)) if !name.contains('/') => (name.to_string(), file),
        _ => (Path::new(word).file_stem().map_or(word.into(), |s| s.to_string_lossy().into_owned()), word),
    }
}

/// A file to read; '-' is standard input.
fn open(name: &str) -> Result<Input> {
    Input::open(Some(Path::new(name)))
}

/// Numbers as text.
fn read(input: Input) -> Result<String> {
    let (mut text, name) = (Vec::new(), input.name);
    input.bytes.take(LONGEST + 1).read_to_end(&mut text).map_err(|e| Error::io(name.clone(), e))?;
    if text.len() as u64 > LONGEST {
        return invalid!("{name}: longer than {} MB", LONGEST >> 20);
    }
    String::from_utf8(text).map_err(|_| Error::Invalid(format!("{name}: not a text")))
}

/// Numbers as what `parse` makes of them.
fn read_as<T>(input: Input, parse: impl FnOnce(&str) -> Result<T>) -> Result<T> {
    let name = input.name.clone();
    parse(&read(input)?).map_err(|e| e.within(&name))
}

impl Pplot {
    /// Tone curves over a histogram, or either alone.
    fn tones(&self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Chart> {
        super::positive("--zoom", self.zoom)?;
        super::positive("--ldmax", self.ldmax)?;
        let bars = match (&self.histogram, input) {
            (_, Some(picture)) => Some(luminances(picture, run)?),
            (Some(name), None) => Some(self.named_histogram(name, run)?),
            (None, None) => None,
        };
        let in_log10 = bars.is_some() && self.zoom.is_none();
        if in_log10 && (self.log || self.log_x) {
            return usage!("beside a histogram the axis across is log10 of luminance already");
        }
        let mut chart = Chart::default();
        for word in &self.curve {
            let (name, file) = named(word);
            let mut points = read_as(open(file)?, data::curve)?;
            let largest = points.iter().map(|p| p.1).filter(|l| l.is_finite()).fold(0.0, f64::max);
            let full = self.ldmax.unwrap_or(largest);
            if full <= 0.0 {
                return invalid!("{}: no display luminance is above 0", printable(file.as_bytes()));
            }
            points.iter_mut().for_each(|p| *p = (if in_log10 { p.0.log10() } else { p.0 }, p.1 / full));
            chart.series.push(Series { name, points, marks: false });
        }
        let even = self.zoom.is_some() || self.linear;
        let log = |yes: bool| if yes { Scale::Log } else { Scale::Linear };
        let world = if in_log10 { "log₁₀ of world luminance (cd/m²)" } else { "world luminance (cd/m²)" };
        chart.x = Axis { label: world.into(), scale: log(!in_log10 && !even), range: self.zoom.map(|z| (0.0, z)) };
        chart.y = Axis { label: "display value (fraction of maximum)".into(), scale: log(!even), range: None };
        if let Some(mut bars) = bars {
            if !in_log10 {
                bars.list.iter_mut().for_each(|b| (b.0, b.1) = (10f64.powf(b.0), 10f64.powf(b.1)));
            }
            let share = Axis { label: format!("{} in each step (%)", bars.name), ..Axis::default() };
            if chart.series.is_empty() {
                bars.name.clear();
                chart.y = share;
            } else {
                chart.second = Some(share);
            }
            chart.bars = Some(bars);
        }
        Ok(chart)
    }

    /// A histogram from a file: ready, or a picture's.
    fn named_histogram(&self, name: &str, run: &Run) -> Result<Bars> {
        let mut input = open(name)?;
        if data::is_histogram(&input.peek(4096)?) {
            return Ok(Bars { name: "counts".into(), list: read_as(input, data::histogram)? });
        }
        let (overrides, limits, name) = (Overrides::default(), run.options.limits(), input.name.clone());
        let reading = Reading { overrides: &overrides, limits: &limits, notes: &run.notes };
        luminances(codec::open(input, &reading)?, run).map_err(|e| e.within(&name))
    }

    fn spectra(&self) -> Result<Chart> {
        let mut chart = Chart::default();
        let mut units = Vec::new();
        for word in &self.spectrum {
            let (name, source) = named(word);
            let (spectrum, text) = if text::is_file(source) {
                let content = read(open(source)?)?;
                (text::parse(source, &content).map_err(|e| e.within(&printable(source.as_bytes())))?, content)
            } else {
                let text = builtin::text(source).unwrap_or("").to_string();
                (source.parse::<SpectrumKey>()?.resolve(Path::new(""))?, text)
            };
            let points = match spectrum {
                Spectrum::Table(points) => points,
                Spectrum::Constant(c) => vec![(380.0, c), (780.0, c)],
            };
            let unit = text.lines().find_map(|l| l.strip_prefix("# unit:"));
            units.push(unit.map(|u| u.split(',').next().unwrap_or("").trim().to_string()));
            chart.series.push(Series { name, points, marks: false });
        }
        units.dedup();
        let unit = if units.len() == 1 { units.pop().flatten() } else { None };
        chart.x.label = "wavelength (nm)".into();
        chart.y.label = unit.unwrap_or("value".into());
        Ok(chart)
    }

    fn table(&self) -> Result<Chart> {
        let mut chart = Chart::default();
        for word in &self.chart {
            let (file_name, file) = named(word);
            let file_shown = printable(file.as_bytes());
            let table = read_as(open(file)?, Table::parse)?;
            let within = |e: Error| e.within(&file_shown);
            let mut free = table.names().iter().filter(|n| Some(*n) != self.by.as_ref() && Some(*n) != self.x.as_ref());
            let two = || Error::Invalid(format!("{file_shown}: expected at least two columns"));
            let x = self.x.as_ref().or_else(|| free.next()).ok_or_else(two)?;
            let ys = if self.y.is_empty() { vec![free.next().ok_or_else(two)?] } else { self.y.iter().collect() };
            let across = table.numbers(x).map_err(within)?;
            let words = self.by.as_ref().map(|by| table.words(by)).transpose().map_err(within)?;
            let mut kinds: Vec<Option<&str>> = Vec::new();
            let all = words.as_ref().map_or(vec![None], |w| w.iter().map(|w| Some(*w)).collect());
            all.into_iter().for_each(|w| {
                if !kinds.contains(&w) {
                    kinds.push(w)
                }
            });
            for y in &ys {
                let up = table.numbers(y).map_err(within)?;
                for kind in &kinds {
                    let own = |i: usize| kind.is_none_or(|k| words.as_ref().is_some_and(|w| w[i] == k));
                    let points: Vec<_> = (0..up.len()).filter(|i| own(*i)).map(|i| (across[i], up[i])).collect();
                    let several = [(self.chart.len() > 1 || word.contains('='), file_name.as_str())];
                    let parts = several.into_iter().filter(|p| p.0).map(|p| p.1);
                    let parts = parts.chain(*kind).chain((ys.len() > 1).then_some(y.as_str()));
                    let name = parts.collect::<Vec<_>>().join(", ");
                    let marks = points.len() <= 40;
                    chart.series.push(Series { name, points, marks });
                }
            }
            chart.x.label = x.clone();
            chart.y.label = ys.iter().map(|y| y.as_str()).collect::<Vec<_>>().join(", ");
        }
        Ok(chart)
    }

    /// What holds for every chart.
    fn dress(&self, chart: &mut Chart) -> Result<()> {
        chart.title = self.title.clone().filter(|t| !t.is_empty());
        for (axis, log, range) in [(&mut chart.x, self.log_x, self.x_range), (&mut chart.y, self.log_y, self.y_range)] {
            if log || self.log {
                axis.scale = Scale::Log;
            }
            axis.range = range.map(|Range(a, b)| (a, b)).or(axis.range);
        }
        let Some(labels) = &self.labels else { return Ok(()) };
        let words: Vec<&str> = labels.split(',').collect();
        let axes = [Some(&mut chart.x), Some(&mut chart.y), chart.second.as_mut()];
        let count = axes.iter().flatten().count();
        if words.len() > count {
            return usage!("--labels '{}': the chart has {count} axes", printable(labels.as_bytes()));
        }
        for (axis, word) in axes.into_iter().flatten().zip(words).filter(|(_, w)| !w.trim().is_empty()) {
            axis.label = word.trim().to_string();
        }
        Ok(())
    }
}

/// Bars of a picture's luminances: log10 cd/m2 and percent of its pixels.
fn luminances(picture: Box<dyn Picture>, run: &Run) -> Result<Bars> {
    if picture.header().units != Units::CdM2 {
        return invalid!(
            "expected scene light in cd/m2 for its histogram, the picture is in {}",
            picture.header().units
        );
    }
    let mut picture = tristimulus::tristimulus(picture)?;
    let (mut found, mut block) = (Luminances::default(), Block::default());
    while picture.next(&mut block)? {
        block.data.chunks_exact(3).for_each(|pixel| found.add(pixel[1]));
    }
    let list = found.bars();
    if list.is_empty() {
        return invalid!("the picture is black: it has no luminance to count");
    }
    if found.dark > 0 {
        run.notes.add(format!("{} pixels have no luminance and are in no step", found.dark));
    }
    Ok(Bars { name: "pixels".into(), list })
}
