//! pdisplay: a display's description from readings of patches or from Radiance's macbethcal, and its check against readings.

use std::fmt::Write as _;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};
use serde::{Deserialize, Serialize};

use crate::color::Xy;
use crate::display::fit::{self, Errors, Fit, MAX_TOLERANCE, MEAN_TOLERANCE};
use crate::display::macbeth::Correction;
use crate::display::readings::Readings;
use crate::display::{Display, Transfer};
use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::stream::Picture;
use crate::stream::output::Output;
use crate::{Error, Result, clap_defaults, invalid, usage};

/// Options of `pdisplay`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pdisplay {
    /// Readings of patches: CSV with the line r,g,b,x,y,Y, codes 0 to 1 (0 to 255 if one is above 1), Y in cd/m2; '-' is
    /// standard input. A fit needs black, white, red, green and blue at full code, and levels between for the curve
    #[arg(value_name = "READINGS", value_hint = ValueHint::FilePath, required = true)]
    pub readings: Option<PathBuf>,
    /// Name in the description's first line; the file's otherwise
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Bits a component that the display takes: 8 or 16
    #[arg(long, value_name = "N", default_value_t = 8)]
    pub bits: u8,
    /// Print what this display should show beside what was read, with Delta E 2000, and exit with status 1 when the largest is
    /// above --tolerance
    #[arg(long, value_name = "DISPLAY", value_hint = ValueHint::FilePath, conflicts_with_all = ["name", "bits"])]
    pub check: Option<Display>,
    /// Largest Delta E 2000 that --check lets pass
    #[arg(long, value_name = "DE", default_value_t = 3.0, requires = "check")]
    pub tolerance: f64,
    /// READINGS is a .cal file of Radiance's macbethcal. It holds colours relative to the chart's white and no luminance: give
    /// --white and --lmax. The three curves are made one, by share of luminance; six straight pieces, continued to 0 and 1;
    /// black is grey. With -c it describes the printer or screen, otherwise the scanner or camera
    #[arg(long, conflicts_with = "check")]
    pub macbethcal: bool,
    /// With --macbethcal: luminance of white, cd/m2
    #[arg(long, value_name = "CD_M2", default_value_t = 100.0, requires = "macbethcal")]
    pub lmax: f64,
    /// With --macbethcal: chromaticity that the chart was calibrated to (its patch 0, or its white); equal energy otherwise
    #[arg(long, value_name = "X,Y", requires = "macbethcal")]
    pub white: Option<Xy>,
    /// With --macbethcal: gamma between codes and the picture values of the .cal file; Radiance's converters have 2.2
    #[arg(long, value_name = "G", default_value_t = 2.2, requires = "macbethcal")]
    pub gamma: f64,
}
clap_defaults!(Pdisplay);

/// No file of readings is longer, bytes.
const LONGEST: u64 = 1 << 20;
/// A mean Delta E 2000 or an additivity error above these gets a note.
const DOUBTFUL: (f64, f64) = (2.0, 0.05);

impl Filter for Pdisplay {
    const NAME: &'static str = "pdisplay";
    const ABOUT: &'static str =
        "Make a display description from readings of patches or from macbethcal's file, or check one against readings";
    const EXAMPLE: &'static str = "pdisplay tests/data/display_readings.csv panel.toml
pdisplay --check srgb tests/data/display_readings.csv
pdisplay --macbethcal --lmax 90 tests/data/macbeth_print.cal print.toml";
    const READS: bool = false;
    const FORMATS: bool = false;
    const SIGNS: bool = false;

    fn start(self, _: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let path = self.readings.clone().ok_or_else(|| Error::Usage("expected READINGS".into()))?;
        self.check_options()?;
        let text = read(&path)?;
        let (text, verdict) = if self.macbethcal {
            (self.of_macbethcal(&text, &path, run).map_err(|e| e.in_file(source(&path)))?, None)
        } else {
            let readings = Readings::parse(&text).map_err(|e| e.in_file(source(&path)))?;
            match &self.check {
                Some(display) => self.compare(display, &readings),
                None => (self.fitted(&readings, &path, run).map_err(|e| e.in_file(source(&path)))?, None),
            }
        };
        let write = Box::new(move |out: &mut Output| {
            out.write_all(text.as_bytes()).map_err(|e| out.error(e))?;
            match verdict {
                Some(verdict) => {
                    out.finish()?;
                    Err(Error::Invalid(verdict))
                }
                None => Ok(()),
            }
        });
        Ok(Product::Bytes { binary: false, write })
    }
}

impl Pdisplay {
    fn check_options(&self) -> Result<()> {
        if ![8, 16].contains(&self.bits) {
            return usage!("--bits {}: a display has 8 or 16", self.bits);
        }
        if self.tolerance.is_nan() || self.tolerance < 0.0 {
            return usage!("--tolerance {} must be at least 0", self.tolerance);
        }
        if !(self.lmax > 0.0 && self.lmax <= 1e6) {
            return usage!("--lmax {} must be a luminance above 0 in cd/m2", self.lmax);
        }
        if !(0.2..=10.0).contains(&self.gamma) {
            return usage!("--gamma {} must be 0.2 to 10", self.gamma);
        }
        Ok(())
    }

    fn title(&self, path: &Path) -> String {
        let stem = path.file_stem().filter(|s| *s != "-");
        let file = stem.map_or("display".into(), |s| s.to_string_lossy().into_owned());
        printable(self.name.clone().unwrap_or(file).as_bytes())
    }

    /// The table of `--check`, and what is wrong if it fails.
    fn compare(&self, display: &Display, readings: &Readings) -> (String, Option<String>) {
        let all = fit::compare(display, &readings.list);
        let Errors { mean, max, line } = fit::errors(display, &readings.list);
        let mut text = format!("# display {}\n#line  r g b  read x y Y  predicted x y Y  Delta E 2000\n", display);
        for (r, d) in readings.list.iter().zip(all) {
            let [x, y, z] = r.code.map(|c| c * readings.full);
            let (read, want) = (shown(r.xyz), shown(display.light(r.code)));
            let _ = writeln!(text, "{:5}  {x:7.3} {y:7.3} {z:7.3}  {read}  {want}  {d:7.3}", r.line);
        }
        let _ = writeln!(text, "# Delta E 2000: mean {mean:.3}, max {max:.3} in line {line}");
        let failed = (max > self.tolerance).then(|| {
            format!(
                "Delta E 2000 reaches {max:.3} in line {line}, above {} (--tolerance); mean {mean:.3}",
                self.tolerance
            )
        });
        (text, failed)
    }

    fn fitted(&self, readings: &Readings, path: &Path, run: &Run) -> Result<String> {
        let found = fit::fit(&self.title(path), readings, self.bits)?;
        remark(&found, run);
        let file = source(path).file_name().map_or(String::new(), |n| printable(n.to_string_lossy().as_bytes()));
        let mut text = format!("# {}\n", found.display.name);
        let count = readings.list.len();
        let _ = writeln!(text, "# Fitted by pdisplay {} to {count} readings of {file}.", env!("CARGO_PKG_VERSION"));
        let Errors { mean, max, line } = found.errors;
        let _ =
            writeln!(text, "# Delta E 2000 of predicted against read: mean {mean:.3}, max {max:.3} in line {line}.");
        for (transfer, e) in &found.tried {
            let _ = writeln!(text, "#   {}: mean {:.3}, max {:.3}", named(transfer), e.mean, e.max);
        }
        let _ = writeln!(
            text,
            "# Of these the simplest within {MEAN_TOLERANCE} (mean) and {MAX_TOLERANCE} (max) of the best was taken."
        );
        let _ = writeln!(
            text,
            "# Additivity: white is {:+.2} % off R + G + B, black subtracted.",
            percent(found.additivity)
        );
        let drift = found.drift.map(|d| d.map_or("not read".into(), |d| format!("{d:.4}")));
        let _ =
            writeln!(text, "# Primaries drift over levels, in x or y: R {}, G {}, B {}.", drift[0], drift[1], drift[2]);
        if found.black_is_zero {
            let _ = writeln!(text, "# Black was read as 0; lmin is a millionth of lmax.");
        }
        let _ = writeln!(text, "# What light of the room the meter saw is within lmax and lmin.");
        Ok(text + &found.display.to_toml())
    }

    fn of_macbethcal(&self, text: &str, path: &Path, run: &Run) -> Result<String> {
        let correction = Correction::parse(text)?;
        let display =
            correction.display(&self.title(path), self.lmax, self.white.unwrap_or(Xy::E), self.gamma, self.bits)?;
        let medium = if correction.printed { "printer or screen (macbethcal -c)" } else { "scanner or camera" };
        if !correction.printed {
            run.notes.add(
                "this file corrects a scanned chart: it describes the scanner or camera, not what shows its pictures",
            );
        }
        let mut out = format!("# {}\n# From macbethcal's correction for a {medium}.\n", display.name);
        let white = self.white.map_or("equal energy".into(), |w| w.to_string());
        let _ = writeln!(
            out,
            "# Not in that file: lmax, {}; white of the chart, {white}; gamma of codes, {}.",
            self.lmax, self.gamma
        );
        out +=
            "# Approximated: one curve for three, black grey, light below the black patch and above the white one.\n";
        Ok(out + &display.to_toml())
    }
}

/// Notes on what should be read before the description is used.
fn remark(found: &Fit, run: &Run) {
    if !found.curve_is_measured {
        run.notes.add("no reading lies between black and full code: the curve is not measured, sRGB is assumed");
    }
    if found.errors.mean > DOUBTFUL.0 {
        run.notes.add(format!(
            "mean Delta E 2000 is {:.1}: three additive primaries with one curve describe this display badly",
            found.errors.mean
        ));
    }
    if found.additivity.abs() > DOUBTFUL.1 {
        run.notes
            .add(format!("white is {:+.1} % off R + G + B: the display is not additive", percent(found.additivity)));
    }
}

/// In hundredths of a percent, without a negative zero.
fn percent(x: f64) -> f64 {
    (1e4 * x).round() / 100.0 + 0.0
}

fn named(transfer: &Transfer) -> String {
    match transfer {
        Transfer::Gamma(g) => format!("gamma {g:.4}"),
        Transfer::Table(light) => format!("table of {}", light.len()),
        Transfer::Srgb => "sRGB".into(),
        Transfer::Pq => "PQ".into(),
        Transfer::Hlg => "HLG".into(),
    }
}

fn shown(xyz: [f64; 3]) -> String {
    let p = Xy::of(xyz).unwrap_or(Xy { x: 0.0, y: 0.0 });
    format!("{:.4} {:.4} {:10.4}", p.x, p.y, xyz[1])
}

/// What messages call the input.
fn source(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new("standard input") } else { path }
}

fn read(path: &Path) -> Result<String> {
    let name = || source(path).display().to_string();
    let mut bytes = Vec::new();
    let done = if path == Path::new("-") {
        std::io::stdin().lock().take(LONGEST + 1).read_to_end(&mut bytes)
    } else {
        crate::files::open(path).and_then(|f| f.take(LONGEST + 1).read_to_end(&mut bytes))
    };
    done.map_err(|e| Error::io(name(), e))?;
    if bytes.len() as u64 > LONGEST {
        return invalid!("{}: longer than {LONGEST} bytes; expected readings of patches", name());
    }
    String::from_utf8(bytes).map_err(|_| Error::Invalid(format!("{}: not a text; expected CSV or a .cal file", name())))
}
