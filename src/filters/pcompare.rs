//! pcompare: how far a picture lies from a reference, as numbers, a map, or a verdict for scripts.
//!
//! Delta E is the one of HDR pictures: the white lies at Yn, the 99th percentile of the reference's Y, and both pixels are
//! first multiplied by min(gain, max(1, 0.5 Yn / Y)), Y the reference's, since a viewer may lift the shadows that far.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::codec::{self, Reading};
use crate::color::{Xy, pu21};
use crate::compare::{Totals, Viewing};
use crate::filter::{Filter, Product, Run};
use crate::json::Json;
use crate::notes::Notes;
use crate::statistics::Distribution;
use crate::stream::meaning::Overrides;
use crate::stream::output::Output;
use crate::stream::picture::Side;
use crate::stream::upright::upright;
use crate::stream::{Block, Components, Header, Picture, Units, picture, reader, spool, tristimulus};
use crate::{Error, Result, clap_defaults, invalid, usage};

/// Options of `pcompare`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pcompare {
    /// Picture to compare with, any kind that INPUT may be. The options below Reading are about INPUT alone
    #[arg(value_name = "REFERENCE", value_hint = ValueHint::FilePath, required = true)]
    pub reference: Option<PathBuf>,
    /// Y of the white, in the pictures' unit; otherwise the 99th percentile of the reference's Y, which is then read twice
    #[arg(long, value_name = "Y")]
    pub white_luminance: Option<f64>,
    /// Dark pixels of both pictures are multiplied by up to this before colours are compared; 1 leaves them as they are
    #[arg(long, value_name = "FACTOR", default_value_t = 10.0)]
    pub gain: f64,
    /// First multiply INPUT by the ratio of the mean Y of the two pictures, which may then have unlike units; reads both twice
    #[arg(long)]
    pub relative: bool,
    /// Compare pictures of unlike white, under that of the reference
    #[arg(long)]
    pub ignore_white: bool,
    /// Print one JSON object instead of text; what is infinite (the PSNR of equal pictures) or does not apply is null
    #[arg(long, help_heading = "Running")]
    pub json: bool,
    /// Write the Delta E 2000 of each pixel as a float stream with COMPONENTS=Y and UNITS=none, NaN where it was left out
    #[arg(long, value_name = "FILE", value_hint = ValueHint::AnyPath, help_heading = "Running")]
    pub map: Option<PathBuf>,
    /// Exit with status 1, after all is written, when the mean Delta E 2000 is above this
    #[arg(long, value_name = "DE", help_heading = "Running")]
    pub fail_above: Option<f64>,
}
clap_defaults!(Pcompare);

/// Whites that differ by more are unlike.
const WHITE_TOLERANCE: f64 = 0.003;
/// Pixels compared at a time, so that a picture that comes as one block costs no more than its pixels.
const PIECE: usize = 1 << 16;

impl Filter for Pcompare {
    const NAME: &'static str = "pcompare";
    const ABOUT: &'static str = "Print how far a picture lies from a reference: colour differences, errors of luminance, PSNR. Percentiles are good to 1 in 1024, in 40 MB for any size; what is read twice is kept if it is a pipe";
    const EXAMPLE: &'static str =
        "pcompare reference.lux render.lux\npcompare --json --map error.lux --fail-above 1 reference.lux < render.lux";
    const FORMATS: bool = false;
    const SIGNS: bool = false;

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        let path = self.reference.as_deref().ok_or_else(|| Error::Usage("expected a REFERENCE".into()))?;
        self.check(path)?;
        let (overrides, limits) = (Overrides::default(), run.options.limits());
        let reading = Reading { overrides: &overrides, limits: &limits, notes: &run.notes };
        let reference = codec::open(reader::Input::open(Some(path))?, &reading)?;
        let input = tristimulus(input).map_err(|e| e.within("INPUT"))?;
        let reference = tristimulus(reference).map_err(|e| e.within("REFERENCE"))?;
        let white = self.common_ground(input.header(), reference.header(), &run.notes)?;
        let run = run.clone();
        let write = Box::new(move |out: &mut Output| self.compare(input, reference, white, &run, out));
        Ok(Product::Bytes { binary: false, write })
    }
}

impl Pcompare {
    fn check(&self, reference: &Path) -> Result<()> {
        let standard = |p: &Path| p == Path::new("-");
        if standard(reference) || self.map.as_deref().is_some_and(standard) {
            return usage!("REFERENCE and --map must be files, not '-'");
        }
        if !(self.gain >= 1.0 && self.gain.is_finite()) {
            return usage!("--gain {} must be at least 1", self.gain);
        }
        if let Some(y) = self.white_luminance.filter(|y| !(*y > 0.0 && y.is_finite())) {
            return usage!("--white-luminance {y} must be above 0");
        }
        if let Some(limit) = self.fail_above.filter(|x| x.is_nan() || *x < 0.0) {
            return usage!("--fail-above {limit} must be at least 0");
        }
        Ok(())
    }

    /// Refuses what cannot be compared; the white both pictures are seen under.
    fn common_ground(&self, input: &Header, reference: &Header, notes: &Notes) -> Result<Xy> {
        let (a, b) = (input.resolution, reference.resolution);
        if (a.width, a.height) != (b.width, b.height) {
            return invalid!(
                "INPUT has {} x {} pixels, REFERENCE {} x {}; no option compares unlike sizes",
                a.width,
                a.height,
                b.width,
                b.height
            );
        }
        if input.units != reference.units && !self.relative {
            return invalid!(
                "INPUT is in {}, REFERENCE in {}; --relative scales the one to the other",
                input.units,
                reference.units
            );
        }
        if let (Some(a), Some(b), false) = (input.display, reference.display, self.relative)
            && a != b
        {
            return invalid!(
                "INPUT is for a display of {} to {} cd/m2, REFERENCE for one of {} to {}; --relative scales the one to the other",
                a[0],
                a[1],
                b[0],
                b[1]
            );
        }
        match (input.white, reference.white) {
            (Some(a), Some(b)) if a.distance(b) > WHITE_TOLERANCE && !self.ignore_white => {
                invalid!("INPUT has the white {a}, REFERENCE {b}; adapt one with vonkries, or give --ignore-white")
            }
            (_, Some(white)) => Ok(white),
            (Some(white), None) => {
                notes.add(format!("REFERENCE has no WHITE line: taking that of INPUT, {white}"));
                Ok(white)
            }
            (None, None) => invalid!("neither picture has a WHITE line; give --white X,Y"),
        }
    }

    fn compare(
        self,
        input: Box<dyn Picture>,
        reference: Box<dyn Picture>,
        white: Xy,
        run: &Run,
        out: &mut Output,
    ) -> Result<()> {
        let limits = run.options.limits();
        let (mut input, mut reference) = (input, reference);
        let mut brightness = Brightness::default();
        if self.relative || self.white_luminance.is_none() {
            reference = spool::twice(reference, &limits, &run.notes, |_, block| brightness.add(block))?;
        }
        let mut scaled = None;
        if self.relative {
            let mut own = Brightness::default();
            input = spool::twice(input, &limits, &run.notes, |_, block| own.add(block))?;
            let factor = brightness.mean("REFERENCE")? / own.mean("INPUT")?;
            let mut header = input.header().clone();
            header.units = reference.header().units;
            header.display = reference.header().display;
            input = picture::map(input, header, move |data| data.iter_mut().for_each(|x| *x *= factor as f32));
            scaled = Some(factor);
        }
        let yn = match self.white_luminance {
            Some(y) => y,
            None => brightness.white()?,
        };
        if input.header().resolution != reference.header().resolution {
            input = upright(input, &limits)?;
            reference = upright(reference, &limits)?;
        }
        let viewing = Viewing {
            white: white.xyz().map(|x| x * yn),
            gain: self.gain,
            shown: match reference.header().units {
                Units::Display => reference.header().display,
                _ => Some([0.0, 1.0]),
            },
        };
        let header = reference.header().clone();
        let mut map = match &self.map {
            Some(path) => Some(Map::create(path, input.header(), &run.history)?),
            None => None,
        };
        let totals = totals(input, reference, &viewing, &mut map)?;
        let Some(mean) = totals.e2000.mean() else {
            return invalid!("no pixel is finite in both pictures");
        };
        let report = Report { header, white, viewing, scaled, totals };
        let text = if self.json { format!("{}\n", report.json()) } else { report.text() };
        out.write_all(text.as_bytes()).map_err(|e| out.error(e))?;
        if let Some(mut map) = map {
            map.out.finish()?;
        }
        match self.fail_above.filter(|limit| mean > *limit) {
            Some(limit) => {
                out.finish()?;
                invalid!("mean Delta E 2000 is {}, above {limit}", short(mean))
            }
            None => Ok(()),
        }
    }
}

/// What a first look at a picture finds.
#[derive(Default)]
struct Brightness {
    y: Distribution,
}

impl Brightness {
    fn add(&mut self, block: &Block) {
        block.data.chunks_exact(3).filter(|p| p[1].is_finite()).for_each(|p| self.y.add(f64::from(p[1])));
    }

    /// Mean Y, for a ratio.
    fn mean(&self, name: &str) -> Result<f64> {
        match self.y.mean() {
            Some(mean) if mean > 0.0 => Ok(mean),
            _ => invalid!("--relative needs a mean Y above 0; {name} has none"),
        }
    }

    /// Yn.
    fn white(&self) -> Result<f64> {
        match self.y.percentile(99.0) {
            Some(y) if y > 0.0 => Ok(y),
            _ => invalid!("the 99th percentile of REFERENCE's Y is not above 0; give --white-luminance"),
        }
    }
}

/// Looks at all pixels of both pictures, which have one size and scan order.
fn totals(
    input: Box<dyn Picture>,
    reference: Box<dyn Picture>,
    viewing: &Viewing,
    map: &mut Option<Map>,
) -> Result<Totals> {
    let mut sides = [input, reference].map(Side::new);
    let (mut totals, mut differences) = (Totals::default(), Vec::new());
    while sides[0].fill()? && sides[1].fill()? {
        let [a, b] = sides.each_ref().map(Side::rest);
        let floats = a.len().min(b.len()).min(3 * PIECE);
        viewing.differences(&a[..floats], &b[..floats], &mut differences);
        totals.add(&differences, viewing);
        if let Some(map) = map {
            let values: Vec<f32> =
                differences.iter().map(|d| if d.left_out { f32::NAN } else { d.e2000 as f32 }).collect();
            map.out.write_all(bytemuck::cast_slice(&values)).map_err(|e| map.out.error(e))?;
        }
        sides.iter_mut().for_each(|s| s.take(floats));
    }
    Ok(totals)
}

/// The error map being written.
struct Map {
    out: Output,
}

impl Map {
    fn create(path: &Path, input: &Header, history: &[u8]) -> Result<Map> {
        let mut header = Header::new(input.resolution, Components::Y, 1, Units::Number);
        header.lines = input.lines.clone();
        header.lines.push(history.to_vec());
        let mut out = Output::create(Some(path), true)?;
        out.write_all(&header.to_bytes("float", &[])).map_err(|e| out.error(e))?;
        Ok(Map { out })
    }
}

/// All there is to print.
struct Report {
    header: Header,
    white: Xy,
    viewing: Viewing,
    scaled: Option<f64>,
    totals: Totals,
}

impl Report {
    fn text(&self) -> String {
        let (t, v) = (&self.totals, &self.viewing);
        let mut text = String::new();
        let r = self.header.resolution;
        let _ =
            writeln!(text, "compared        {} x {} pixels, {} left out (not finite)", r.width, r.height, t.left_out);
        let (yn, units) = (short(v.white[1]), self.header.units);
        let _ =
            writeln!(text, "white           {:.4} {:.4}, Yn {yn} {units}, gain {}", self.white.x, self.white.y, v.gain);
        if let Some(factor) = self.scaled {
            let _ = writeln!(text, "scaled          INPUT x {} (--relative)", short(factor));
        }
        let _ = writeln!(text, "{:16}{:>12}{:>12}{:>12}", "", "mean", "95 %", "max");
        let row = |name: &str, d: &Distribution| {
            let [mean, p95, max] = [d.mean(), d.percentile(95.0), d.max()].map(|x| x.map_or("none".into(), short));
            format!("{name:16}{mean:>12}{p95:>12}{max:>12}")
        };
        for (name, d) in [("Delta E*uv", &t.uv), ("Delta E*ab", &t.ab), ("Delta E 2000", &t.e2000)] {
            let _ = writeln!(text, "{}", row(name, d));
        }
        let mean = t.relative_mean().map_or("none".into(), short);
        let _ = write!(text, "{} absolute, signed mean {mean}", row("relative Y", &t.relative));
        let dark = t.count() - t.relative.count();
        if dark > 0 {
            let _ = write!(text, ", without {dark} pixels where REFERENCE is not above 0");
        }
        let _ = writeln!(text, "\nrelative MSE Y  {:>12}", short(t.relative_mse()));
        let _ = writeln!(text, "PSNR Y          {:>12} dB, peak {}", short(t.psnr_y()), short(t.peak_y));
        let _ = match v.shown {
            Some(_) => writeln!(
                text,
                "PSNR PU21       {:>12} dB, peak {}, {} pixels clamped to {} to {} cd/m2",
                short(t.psnr_pu21()),
                pu21::PEAK,
                t.clamped,
                pu21::RANGE[0],
                pu21::RANGE[1]
            ),
            None => writeln!(text, "PSNR PU21               none: REFERENCE has no DISPLAY line"),
        };
        text
    }

    fn json(&self) -> Json {
        let (t, v) = (&self.totals, &self.viewing);
        let spread =
            |d: &Distribution| [("mean", d.mean().into()), ("p95", d.percentile(95.0).into()), ("max", d.max().into())];
        let relative = &t.relative;
        let relative = Json::object([
            ("mean_signed", t.relative_mean().into()),
            ("mean_absolute", relative.mean().into()),
            ("p95_absolute", relative.percentile(95.0).into()),
            ("max_absolute", relative.max().into()),
            ("without_reference", (t.count() - relative.count()).into()),
        ]);
        Json::object([
            ("width", self.header.resolution.width.into()),
            ("height", self.header.resolution.height.into()),
            ("left_out", t.left_out.into()),
            ("units", self.header.units.name().into()),
            ("white", Json::list([self.white.x, self.white.y])),
            ("white_luminance", v.white[1].into()),
            ("gain", v.gain.into()),
            ("scaled", self.scaled.into()),
            ("delta_e_uv", Json::object(spread(&t.uv))),
            ("delta_e_ab", Json::object(spread(&t.ab))),
            ("delta_e_2000", Json::object(spread(&t.e2000))),
            ("relative_y", relative),
            ("relative_mse_y", t.relative_mse().into()),
            ("psnr_y_db", t.psnr_y().into()),
            ("peak_y", t.peak_y.into()),
            ("psnr_pu21_db", v.shown.map(|_| t.psnr_pu21()).into()),
            ("pu21_clamped", v.shown.map(|_| t.clamped).into()),
        ])
    }
}

/// Six significant digits, plain where that is short.
fn short(x: f64) -> String {
    let size = x.abs();
    if size != 0.0 && size.is_finite() && !(1e-4..1e6).contains(&size) {
        return format!("{x:.5e}");
    }
    let digits = if size == 0.0 || !size.is_finite() { 0 } else { 5 - size.log10().floor() as i32 };
    format!("{x:.*}", digits.clamp(0, 10) as usize)
}
