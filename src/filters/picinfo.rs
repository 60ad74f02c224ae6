//! picinfo: what a picture is and what it holds.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::codec::{self, Reading};
use crate::color::{Primaries, Xy};
use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::filters::pcond;
use crate::json::Json;
use crate::options::ReadOptions;
use crate::stream::meaning::Overrides;
use crate::stream::output::Output;
use crate::stream::{Block, Components, Header, Picture, Units, reader};
use crate::tone::Histogram;
use crate::{Error, Result, usage};

/// Options of `picinfo`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Picinfo {
    /// Print one JSON object instead of text; what the picture does not have is null
    #[arg(long, help_heading = "Running")]
    pub json: bool,
    /// Print instead the histogram that pcond would take, 100 lines of log10 luminance and weight, for pcond --histogram: half
    /// the weight to the picture in cells of a degree, half to its pixels
    #[arg(long, conflicts_with = "json")]
    pub histogram: bool,
    /// With --histogram: more pictures, such as the frames of a film, each of equal weight
    #[arg(long, value_name = "FILE", num_args = 1.., value_hint = ValueHint::FilePath, requires = "histogram")]
    pub also: Vec<PathBuf>,
}
clap_defaults!(Picinfo);

/// Statistics of one component.
#[derive(Clone, Copy, Debug)]
struct Extremes {
    min: f32,
    max: f32,
    sum: f64,
    finite: u64,
    negative: u64,
    nan: u64,
    infinite: u64,
}

impl Extremes {
    const NONE: Extremes =
        Extremes { min: f32::MAX, max: f32::MIN, sum: 0.0, finite: 0, negative: 0, nan: 0, infinite: 0 };

    fn add(&mut self, x: f32) {
        if x.is_finite() {
            self.min = self.min.min(x);
            self.max = self.max.max(x);
            self.sum += f64::from(x);
            self.finite += 1;
            self.negative += u64::from(x < 0.0);
        } else if x.is_nan() {
            self.nan += 1;
        } else {
            self.infinite += 1;
        }
    }

    fn mean(&self) -> Option<f64> {
        (self.finite > 0).then(|| self.sum / self.finite as f64)
    }

    fn json(&self, name: &str) -> Json {
        let some = self.finite > 0;
        Json::object([
            ("name", name.into()),
            ("min", some.then_some(self.min).into()),
            ("max", some.then_some(self.max).into()),
            ("mean", self.mean().into()),
            ("finite", self.finite.into()),
            ("negative", self.negative.into()),
            ("nan", self.nan.into()),
            ("infinite", self.infinite.into()),
        ])
    }

    fn line(&self, name: &str) -> String {
        let mut line = match self.mean() {
            None => format!("{name:<12}no finite value"),
            Some(mean) => format!("{name:<12}{:.6e} to {:.6e}, mean {mean:.6e}", self.min, self.max),
        };
        for (count, what) in [(self.negative, "negative"), (self.nan, "NaN"), (self.infinite, "infinite")] {
            if count > 0 {
                let _ = write!(line, ", {count} {what}");
            }
        }
        line
    }
}

/// Decades of luminance that the histogram shows.
const DECADES: std::ops::RangeInclusive<i32> = -8..=12;

impl Filter for Picinfo {
    const NAME: &'static str = "picinfo";
    const ABOUT: &'static str = "Print a picture's header, units, extremes and luminance histogram by decades, 1e-8 and 1e12 taking in what lies beyond";
    const EXAMPLE: &'static str = "picinfo out/cornell.hdr";
    const FORMATS: bool = false;
    const SIGNS: bool = false;

    /// Who writes `picinfo --histogram one.hdr two.hdr`, as one would with Radiance's phisto, must not lose the second.
    fn placed(&mut self, _: &ReadOptions, output: Option<&Path>) -> Result<()> {
        match output.filter(|p| self.histogram && p.exists()) {
            Some(p) => {
                usage!("{} exists; name further pictures with --also", printable(p.as_os_str().as_encoded_bytes()))
            }
            None => Ok(()),
        }
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let mut picture = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        if self.histogram {
            let text = self.histogram(picture, run)?;
            let write = Box::new(move |out: &mut Output| {
                std::io::Write::write_all(out, text.as_bytes()).map_err(|e| out.error(e))
            });
            return Ok(Product::Bytes { binary: false, write });
        }
        let write = Box::new(move |out: &mut Output| {
            let found = Findings::of(&mut *picture)?;
            let text = if self.json { format!("{}\n", found.json()) } else { found.text() };
            std::io::Write::write_all(out, text.as_bytes()).map_err(|e| out.error(e))
        });
        Ok(Product::Bytes { binary: false, write })
    }
}

/// Lines of a histogram.
const LINES: usize = 100;

impl Picinfo {
    /// The histograms of all pictures, each of weight 1, as text.
    fn histogram(&self, first: Box<dyn Picture>, run: &Run) -> Result<String> {
        let mut sum = Histogram::default();
        let mut add = |picture: Box<dyn Picture>| -> Result<()> {
            let one = seen(picture)?;
            if one.total() > 0.0 {
                sum.merge(&one, 1.0 / one.total());
            }
            Ok(())
        };
        add(first)?;
        let (overrides, limits) = (Overrides::default(), run.options.limits());
        for path in &self.also {
            let reading = Reading { overrides: &overrides, limits: &limits, notes: &run.notes };
            add(codec::open(reader::Input::open(Some(path))?, &reading)?)?;
        }
        if sum.range_cd_m2().is_none() {
            return crate::invalid!("no pixel has a luminance");
        }
        Ok(sum.to_text(LINES))
    }
}

/// The histogram of one picture as an eye would take it in.
fn seen(picture: Box<dyn Picture>) -> Result<Histogram> {
    if picture.header().units == Units::Display {
        return crate::invalid!("the picture is display-referred; a histogram is the world's");
    }
    pcond::histogram(picture)
}

/// What all pixels of a picture say.
struct Findings {
    header: Header,
    each: Vec<Extremes>,
    /// Nothing for a picture whose luminance is not a row of numbers.
    luminance: Option<Luminance>,
}

struct Luminance {
    extremes: Extremes,
    /// Pixels in each of [`DECADES`]; the outermost hold what lies beyond.
    decades: [u64; (*DECADES.end() - *DECADES.start()) as usize + 1],
    /// Pixels in none: zero, negative or not finite.
    dark: u64,
}

impl Findings {
    fn of(picture: &mut dyn Picture) -> Result<Findings> {
        let header = picture.header().clone();
        let mut each = vec![Extremes::NONE; header.ncomp];
        let row = luminance_row(&header);
        let mut l = Luminance { extremes: Extremes::NONE, decades: Default::default(), dark: 0 };
        let mut block = Block::default();
        while picture.next(&mut block)? {
            for pixel in block.data.chunks_exact(header.ncomp) {
                each.iter_mut().zip(pixel).for_each(|(e, x)| e.add(*x));
                if let Some(row) = &row {
                    // A weight of 0 is no part of the sum: NaN in X leaves Y what it is.
                    l.add(row.iter().zip(pixel).filter(|(a, _)| **a != 0.0).map(|(a, b)| a * f64::from(*b)).sum());
                }
            }
        }
        Ok(Findings { header, each, luminance: row.map(|_| l) })
    }

    fn text(&self) -> String {
        let mut text = describe(&self.header);
        for (name, extremes) in component_names(&self.header).iter().zip(&self.each) {
            let _ = writeln!(text, "{}", extremes.line(name));
        }
        let Some(l) = &self.luminance else { return text };
        let _ = writeln!(text, "{}", l.extremes.line("luminance"));
        let total = (self.header.resolution.width * self.header.resolution.height) as f64;
        for (decade, count) in l.filled() {
            let share = 100.0 * count as f64 / total;
            let _ = writeln!(text, "  1e{decade:<+4} {share:6.2} % {}", "#".repeat((share / 2.0).ceil() as usize));
        }
        if l.dark > 0 {
            let _ = writeln!(text, "  none   {:6.2} %", 100.0 * l.dark as f64 / total);
        }
        text
    }

    fn json(&self) -> Json {
        let h = &self.header;
        let order = h.resolution.to_string();
        let order: Vec<&str> = order.split_ascii_whitespace().step_by(2).collect();
        let xy = |w: Xy| Json::list([w.x, w.y]);
        let nm = h.sampling.as_ref().map(|s| Json::list((0..s.count()).map(|i| s.centre_nm(i))));
        let adapted = h.adapted.as_ref().map(|a| {
            let (cat, degree) = (a.cat.as_str().into(), a.degree.into());
            Json::object([("from", xy(a.from)), ("to", xy(a.to)), ("cat", cat), ("degree", degree)])
        });
        let statistics = component_names(h).into_iter().zip(&self.each).map(|(name, e)| e.json(&name));
        let decades = self.luminance.as_ref().map(|l| {
            Json::list(
                l.filled().map(|(decade, count)| Json::object([("decade", decade.into()), ("pixels", count.into())])),
            )
        });
        Json::object([
            ("width", h.resolution.width.into()),
            ("height", h.resolution.height.into()),
            ("order", order.join(" ").as_str().into()),
            ("components", h.components.name().into()),
            ("ncomp", h.ncomp.into()),
            ("units", h.units.name().into()),
            ("wavelengths_nm", nm.into()),
            ("primaries", h.primaries.map(|p| Json::list(p.numbers())).into()),
            ("white", h.white.map(xy).into()),
            ("adapted", adapted.into()),
            ("display_cd_m2", h.display.map(Json::list).into()),
            ("lines", Json::list(h.lines.iter().map(Vec::as_slice))),
            ("statistics", Json::list(statistics)),
            ("luminance", self.luminance.as_ref().map(|l| l.extremes.json("luminance")).into()),
            ("luminance_decades", decades.into()),
            ("luminance_in_no_decade", self.luminance.as_ref().map(|l| l.dark).into()),
        ])
    }
}

impl Luminance {
    fn add(&mut self, l: f64) {
        self.extremes.add(l as f32);
        if l > 0.0 && l.is_finite() {
            let decade = (l.log10().floor() as i32).clamp(*DECADES.start(), *DECADES.end());
            self.decades[(decade - DECADES.start()) as usize] += 1;
        } else {
            self.dark += 1;
        }
    }

    /// Decades with pixels in them, and how many.
    fn filled(&self) -> impl Iterator<Item = (i32, u64)> {
        DECADES.zip(self.decades).filter(|(_, count)| *count > 0)
    }
}

fn describe(header: &Header) -> String {
    let mut text = String::new();
    let r = header.resolution;
    let order = r.to_string();
    let order: Vec<&str> = order.split_ascii_whitespace().collect();
    let _ = writeln!(text, "size        {} x {}, stored {} {}", r.width, r.height, order[0], order[2]);
    let _ = writeln!(text, "components  {} ({}), {}", header.components, header.ncomp, header.units);
    if let Some(s) = &header.sampling {
        let (a, b) = (s.centre_nm(0), s.centre_nm(s.count() - 1));
        let _ = writeln!(text, "wavelengths {} from {a} to {b} nm", s.count());
    }
    if let Some(p) = header.primaries {
        let _ = writeln!(text, "primaries   {p}");
    }
    if let Some(w) = header.white {
        let _ = writeln!(text, "white       {:.4} {:.4}", w.x, w.y);
    }
    if let Some(a) = &header.adapted {
        let _ = writeln!(
            text,
            "adapted     from {} to {} by {}, degree {}",
            a.from,
            a.to,
            printable(a.cat.as_bytes()),
            a.degree
        );
    }
    if let Some([min, max]) = header.display {
        let _ = writeln!(text, "display     {min} to {max} cd/m2");
    }
    for line in &header.lines {
        let _ = writeln!(text, "line        {}", printable(line));
    }
    text
}

fn component_names(header: &Header) -> Vec<String> {
    let letters = |s: &str| s.chars().map(String::from).collect();
    match (header.components, &header.sampling) {
        (Components::Xyz, _) => letters("XYZ"),
        (Components::Rgb, _) => letters("RGB"),
        (Components::Spectrum, Some(s)) => (0..s.count()).map(|i| format!("{:.1} nm", s.centre_nm(i))).collect(),
        _ => (1..=header.ncomp).map(|i| format!("{i}")).collect(),
    }
}

/// The row that gives luminance (or its display-referred share) from the components.
fn luminance_row(header: &Header) -> Option<Vec<f64>> {
    match header.components {
        Components::Y => (header.units != Units::Number).then(|| vec![1.0]),
        Components::Xyz => Some(vec![0.0, 1.0, 0.0]),
        Components::Rgb => header.primaries.unwrap_or(Primaries::RADIANCE).to_xyz().map(|m| m.0[1].to_vec()),
        Components::Spectrum | Components::Stokes | Components::Response | Components::Layers => None,
    }
}
