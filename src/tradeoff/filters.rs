//! What comes after a renderer, by the same measure: encodings (error against bytes and speed), tone maps (time against what stays
//! visible), adaptation (constancy of the colour checker).

use std::path::Path;

use crate::Result;
use crate::color::relative::Grid;
use crate::color::{Cat, Mat3, difference};
use crate::spectral::builtin;
use crate::stream::spool::Limits;
use crate::tone::threshold::threshold_cd_m2;
use crate::tradeoff::child::Programs;
use crate::tradeoff::judge::Seen;

/// A table of the page.
pub struct Table {
    /// Above it.
    pub title: &'static str,
    /// What it says.
    pub about: String,
    /// Heads of its columns.
    pub columns: &'static [&'static str],
    /// Rows of as many.
    pub rows: Vec<Vec<String>>,
}

/// Commands that record a picture, with the suffix of their file.
const ENCODINGS: [(&str, &str); 11] = [
    ("ra_rgbe", "hdr"),
    ("ra_rgbe --xyze", "hdr"),
    ("ra_loglv", "tif"),
    ("ra_loglv --bits24", "tif"),
    ("ra_loglv --bits24 --dither", "tif"),
    ("ra_pixlog", "tif"),
    ("ra_exr", "exr"),
    ("ra_exr --to XYZ", "exr"),
    ("ra_exr --to XYZ --float", "exr"),
    ("ra_pfm", "pfm"),
    ("vonkries --to D65", "lux"),
];
const TONES: [&str; 6] = ["pcond -l", "pcond", "pcond -s", "pcond -h", "plocal", "plocal --method retinex"];
const LIGHTS: [&str; 6] = ["A", "D50", "FL2", "FL11", "LED-B3", "LED-RGB1"];
/// Luminances of the screen that tone maps are judged on, cd/m2.
const SCREEN: [f64; 2] = [1.0, 100.0];
/// Pixels along a side of a field that is looked at.
const FIELD: usize = 2;

/// A picture that filters are tried on.
pub struct Bench<'a> {
    /// The programs.
    pub programs: &'a Programs,
    /// Memory for pictures.
    pub limits: &'a Limits,
    /// For files on the way.
    pub folder: &'a Path,
    /// XYZ in cd/m2, adapted to D65.
    pub picture: &'a Path,
    /// Dark pixels are looked at up to so many times brighter.
    pub gain: f64,
}

impl Bench<'_> {
    fn words(&self, command: &str, input: &Path) -> (String, Vec<String>) {
        let mut words = command.split_whitespace().map(String::from);
        let name = words.next().unwrap_or_default();
        (name, words.chain([input.display().to_string(), "--quiet".into()]).collect())
    }

    /// Error against bytes and time of the encodings.
    pub fn encodings(&self) -> Result<Table> {
        let original = Seen::read(self.picture, self.limits)?;
        let white_y = original.white_y(&[])?;
        let pixels = original.xyz.len() / 3;
        let mut rows = Vec::new();
        for (command, suffix) in ENCODINGS {
            let file = self.folder.join(format!("coded.{suffix}"));
            let (name, words) = self.words(command, self.picture);
            let written = self.programs.run(&name, &words, &file)?;
            let label = if suffix == "lux" { "float stream".to_string() } else { command.to_string() };
            let mut row = vec![label];
            match written {
                Ok(ran) => {
                    let bytes = std::fs::metadata(&file).map_or(0, |m| m.len());
                    let begin = std::time::Instant::now();
                    let errors = original.errors_of(&Seen::read(&file, self.limits)?, white_y, self.gain)?;
                    let read_ms = 1e3 * begin.elapsed().as_secs_f64();
                    row.push(format!("{:.2}", bytes as f64 / pixels as f64));
                    row.extend([errors.rms, errors.p95].map(|e| format!("{e:.3}")));
                    row.push(format!("{:.3}", 100.0 * errors.relative_rmse));
                    row.extend([1e3 * ran.seconds, read_ms].map(|t| format!("{t:.1}")));
                }
                Err(said) => {
                    row.extend([said, String::new(), String::new(), String::new(), String::new(), String::new()])
                }
            }
            rows.push(row);
        }
        Ok(Table {
            title: "Encodings",
            about: format!("A picture of {pixels} pixels, recorded and read again; the whole program's time."),
            columns: &[
                "encoding",
                "bytes a pixel",
                "Delta E rms",
                "95 %",
                "Y rms, %",
                "write, ms",
                "read and compare, ms",
            ],
            rows,
        })
    }

    /// Time of tone maps against what stays visible.
    pub fn tones(&self) -> Result<Table> {
        let world = Fields::of(&Seen::read(self.picture, self.limits)?, |y| y);
        let mut rows = Vec::new();
        for command in TONES {
            let file = self.folder.join("toned.lux");
            let (name, words) = self.words(command, self.picture);
            let mut row = vec![command.to_string()];
            match self.programs.run(&name, &words, &file)? {
                Ok(ran) => {
                    let [black, white] = SCREEN;
                    let toned = Seen::read(&file, self.limits)?;
                    let shown = Fields::of(&toned, |y| black + (white - black) * y.clamp(0.0, 1.0));
                    row.extend(world.agreement(&shown).map(|a| format!("{:.1}", 100.0 * a)));
                    row.push(format!("{:.1}", 1e3 * ran.seconds));
                }
                Err(said) => row.extend([said, String::new(), String::new(), String::new()]),
            }
            rows.push(row);
        }
        Ok(Table {
            title: "Tone maps",
            about: format!(
                "Differences between neighbouring fields of {FIELD} x {FIELD} pixels that an eye adapted to them sees in the world (Ferwerda 1996), and on a screen of {} to {} cd/m2.",
                SCREEN[0], SCREEN[1]
            ),
            columns: &["tone map", "agree, %", "visible ones kept, %", "invisible ones that show, %", "time, ms"],
            rows,
        })
    }
}

/// Mean luminances of fields.
struct Fields {
    width: usize,
    y: Vec<f64>,
}

impl Fields {
    fn of(seen: &Seen, luminance: impl Fn(f64) -> f64) -> Fields {
        let full = seen.header.resolution.width;
        let (width, height) = (full / FIELD, seen.header.resolution.height / FIELD);
        let pixel = |x: usize, y: usize| luminance(f64::from(seen.xyz[3 * (y * full + x) + 1]));
        let mean = |i: usize| {
            let (x, y) = (i % width * FIELD, i / width * FIELD);
            let all = (0..FIELD * FIELD).map(|k| pixel(x + k % FIELD, y + k / FIELD));
            all.sum::<f64>() / (FIELD * FIELD) as f64
        };
        Fields { width, y: (0..width * height).map(mean).collect() }
    }

    /// Pairs of neighbours that can be told apart.
    fn visible(&self) -> Vec<bool> {
        let sees = |a: f64, b: f64| (a - b).abs() > threshold_cd_m2(0.5 * (a + b));
        let right = (0..self.y.len()).filter(|i| (i + 1) % self.width != 0).map(|i| sees(self.y[i], self.y[i + 1]));
        let below = (self.width..self.y.len()).map(|i| sees(self.y[i], self.y[i - self.width]));
        right.chain(below).collect()
    }

    /// Shares of pairs: seen in both or in neither; of those seen here, seen there too; of those not seen here, seen there.
    fn agreement(&self, shown: &Fields) -> [f64; 3] {
        let (world, screen) = (self.visible(), shown.visible());
        let count =
            |test: fn(bool, bool) -> bool| world.iter().zip(&screen).filter(|(w, s)| test(**w, **s)).count() as f64;
        let share = |part: f64, all: f64| if all > 0.0 { part / all } else { f64::NAN };
        let (seen, unseen) = (count(|w, _| w), count(|w, _| !w));
        [
            share(count(|w, s| w == s), seen + unseen),
            share(count(|w, s| w && s), seen),
            share(count(|w, s| !w && s), unseen),
        ]
    }
}

/// How near each adaptation brings the colour checker under a light to itself under D65.
pub fn adaptations() -> Result<Table> {
    let grid = Grid::cie1931()?;
    let checker = builtin::names().filter(|n| n.starts_with("cc_ohta_"));
    let patches: Vec<Vec<f64>> = checker.map(|n| Ok(grid.sample(&builtin::spectrum(n)?))).collect::<Result<_>>()?;
    let light = |name: &str| Ok::<_, crate::Error>(grid.sample(&builtin::spectrum(&format!("illuminant_{name}"))?));
    let day = light("D65")?;
    let day_white = grid.xyz(&day, &[]);
    let mut rows = Vec::new();
    for cat in <Cat as clap::ValueEnum>::value_variants() {
        let sensors = cat.matrix();
        let Some(back) = sensors.inverse() else { continue };
        let mut row = vec![cat.name()];
        let mut all = Vec::new();
        for name in LIGHTS {
            let source = light(name)?;
            let (from, to) = (sensors.apply(grid.xyz(&source, &[])), sensors.apply(day_white));
            let adapt = back.times(&Mat3::diagonal([0, 1, 2].map(|i| to[i] / from[i]))).times(&sensors);
            let error = |p: &Vec<f64>| {
                let (got, want) = (adapt.apply(grid.xyz(&source, &[p])), grid.xyz(&day, &[p]));
                difference::delta_e_2000(got, want, day_white)
            };
            let errors: Vec<f64> = patches.iter().map(error).collect();
            row.push(format!("{:.2}", errors.iter().sum::<f64>() / errors.len() as f64));
            all.extend(errors);
        }
        row.push(format!("{:.2}", all.iter().sum::<f64>() / all.len() as f64));
        row.push(format!("{:.1}", all.iter().copied().fold(0.0, f64::max)));
        rows.push(row);
    }
    Ok(Table {
        title: "Chromatic adaptation",
        about: "Mean Delta E 2000 of the 24 patches of a colour checker (Ohta), adapted from each light to D65, against the patches under D65: the constancy of these surfaces, not what observers see. A matrix costs the same whatever its numbers.".into(),
        columns: &["adaptation", "A", "D50", "FL2", "FL11", "LED-B3", "LED-RGB1", "all", "largest"],
        rows,
    })
}
