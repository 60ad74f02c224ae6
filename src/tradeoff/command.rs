//! The program's command line, and the order of its work.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueHint};

use crate::error::printable;
use crate::filter;
use crate::options::RunOptions;
use crate::render::estimate::MOST_WAVELENGTHS;
use crate::stream::output::Output;
use crate::tradeoff::chart::{self, CHARTS};
use crate::tradeoff::child::Programs;
use crate::tradeoff::filters::{self, Bench, Table};
use crate::tradeoff::methods::{METHODS, PLANS};
use crate::tradeoff::page::{self, Section};
use crate::tradeoff::reference::Making;
use crate::tradeoff::scene::{Subject, Wanted};
use crate::tradeoff::table::{self, Kind, Row};
use crate::{Error, Result, usage};

/// Command line of `tradeoff`.
#[derive(Args, Clone, Debug)]
pub struct Tradeoff {
    /// Scenes to try (TOML)
    #[arg(value_name = "SCENE", value_hint = ValueHint::FilePath, required = true)]
    pub scenes: Vec<PathBuf>,
    /// Folder for the table (tradeoff.csv), the charts (SVG and PNG) and the page (tradeoff.html)
    #[arg(short, long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub out: PathBuf,
    /// Methods to try, parted by commas, or none; march and zonal where the scene has media
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_value = "local,path,radiosity,photon,march,zonal")]
    pub methods: Vec<String>,
    /// What paths are to carry, parted by commas, or none: models of specplan, bandsN, and specplan's own choice
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "white,product,relative,4,8,12,16,bands18,bands80,specplan"
    )]
    pub plans: Vec<String>,
    /// Colour error that specplan plans for, Delta E 2000
    #[arg(long, value_name = "DE", default_value_t = 0.5)]
    pub tolerance: f64,
    /// Dark pixels are looked at up to so many times brighter
    #[arg(long, value_name = "FACTOR", default_value_t = 10.0)]
    pub gain: f64,
    /// Seconds after which a run is its method's last
    #[arg(long, value_name = "SECONDS", default_value_t = 3.0)]
    pub seconds: f64,
    /// Seconds for a reference that is not kept already
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0)]
    pub reference_seconds: f64,
    /// Folder where references are kept; OUT/references unless given
    #[arg(long, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub references: Option<PathBuf>,
    /// Paths a pixel that plans are compared by
    #[arg(long, value_name = "N", default_value_t = 16)]
    pub samples: u32,
    /// Pixels across, in place of the scenes' own
    #[arg(long, value_name = "PIXELS")]
    pub width: Option<usize>,
    /// Also encodings, tone maps and adaptations, on the first scene's reference
    #[arg(long)]
    pub filters: bool,
    /// How to run.
    #[command(flatten)]
    pub run: RunOptions,
}

/// The command line of `tradeoff`.
pub fn command() -> clap::Command {
    let about = "Try methods and plans on scenes: error against a converged reference beside time and memory, as a table, charts and a page";
    let example = "tradeoff scenes/cornell.toml scenes/caustic.toml --width 128 -o out/tradeoff\ntradeoff scenes/fogbox.toml --methods path,zonal --plans none --seconds 10 -o out/fog";
    filter::dress(Tradeoff::augment_args(clap::Command::new("tradeoff")), about, example)
}

/// A list without `none`, all of whose words are known.
fn list(option: &str, words: &[String], known: &[&str], more: impl Fn(&str) -> bool) -> Result<Vec<String>> {
    let words: Vec<String> = words.iter().filter(|w| *w != "none" && !w.is_empty()).cloned().collect();
    match words.iter().find(|w| !known.contains(&w.as_str()) && !more(w)) {
        Some(word) => {
            let more = if option == "--plans" { ", 1 to 32 wavelengths, bands1 to bands480" } else { "" };
            usage!("{option}: '{}' is none of {}, none{more}", printable(word.as_bytes()), known.join(", "))
        }
        None => Ok(words),
    }
}

impl Tradeoff {
    fn wanted(&self) -> Result<Wanted> {
        let within = |n: &str, most: usize| {
            n.bytes().all(|b| b.is_ascii_digit()) && n.parse().is_ok_and(|n: usize| (1..=most).contains(&n))
        };
        let bands = |w: &str| w.strip_prefix("bands").is_some_and(|n| within(n, MOST_WAVELENGTHS));
        let count = |w: &str| within(w, 32);
        let methods: Vec<&str> = METHODS.iter().map(|m| m.name).collect();
        for (option, x) in [("--seconds", self.seconds), ("--reference-seconds", self.reference_seconds)] {
            if !(x > 0.0 && x < 1e7) {
                return usage!("{option} {x}: seconds above 0");
            }
        }
        if !(self.tolerance > 0.0 && self.tolerance <= 100.0)
            || self.width.is_some_and(|w| !(1..=1_000_000).contains(&w))
        {
            return usage!("--tolerance is a Delta E 2000 above 0, --width 1 to 1000000 pixels");
        }
        let names: Vec<_> = self.scenes.iter().map(|s| s.file_stem()).collect();
        if let Some(i) = (1..names.len()).find(|i| names[..*i].contains(&names[*i])) {
            let name = printable(names[i].unwrap_or_default().as_encoded_bytes());
            return usage!("two scenes are called '{name}': their charts and references would have one name");
        }
        if !(self.gain >= 1.0 && self.gain <= 1e6) || self.samples == 0 {
            return usage!("--gain is a factor from 1, --samples at least 1");
        }
        Ok(Wanted {
            methods: list("--methods", &self.methods, &methods, |_| false)?,
            plans: list("--plans", &self.plans, &PLANS, |w| bands(w) || count(w))?,
            seconds: self.seconds,
            tolerance: self.tolerance,
            samples: self.samples,
        })
    }

    /// Does it all; each run is told as it ends, and all that is known is written after each scene.
    ///
    /// # Errors
    /// Scenes that cannot be rendered at all, files that cannot be written. What a method refuses is a row of the table.
    pub fn run(&self) -> Result<()> {
        let wanted = self.wanted()?;
        let programs = Programs::beside(self.run.threads)?;
        let references = self.references.clone().unwrap_or_else(|| self.out.join("references"));
        for scene in &self.scenes {
            crate::files::open(scene).map_err(|e| Error::io(printable(scene.as_os_str().as_encoded_bytes()), e))?;
        }
        std::fs::create_dir_all(&self.out).map_err(|e| Error::io(self.out.display().to_string(), e))?;
        let folder =
            tempfile::tempdir_in(&self.run.tmp).map_err(|e| Error::io(self.run.tmp.display().to_string(), e))?;
        let limits = self.run.limits();
        let making = Making {
            programs: &programs,
            limits: &limits,
            width: self.width,
            seconds: self.reference_seconds,
            kept: &references,
            folder: folder.path(),
            gain: self.gain,
        };
        let (mut sections, mut tables) = (Vec::new(), Vec::new());
        for path in &self.scenes {
            let name = path.file_stem().map_or("scene".into(), |s| printable(s.as_encoded_bytes()));
            let subject = Subject { path, name: &name, making: &making, wanted: &wanted };
            let rows = subject.rows(&mut |row| self.tell(row)).map_err(|e| e.in_file(path))?;
            let charts = self.charts(&name, &rows)?;
            sections.push(Section { about: about(path)?, name, charts, rows });
            if self.filters && tables.is_empty() {
                tables = self.tables(&making, path, &sections[0].name)?;
            }
            self.write(&sections, &tables)?;
        }
        Ok(())
    }

    fn tell(&self, row: &Row) {
        if self.run.quiet {
            return;
        }
        let found = format!("Y {:7.2} %  Delta E {:7.3}", 100.0 * row.relative_rmse, row.delta_e[0]);
        let rest = match (row.kind, row.is_measured()) {
            (Kind::Reference, _) => format!("           {found}  standard error, {}", row.setting),
            (_, true) => format!("{:8.2} s {found}  {}", row.seconds, row.setting),
            (_, false) => row.note.clone(),
        };
        let _ = writeln!(std::io::stderr(), "{:14} {:10} {:24} {rest}", row.scene, row.kind.name(), row.name);
    }

    /// Draws a scene's charts into files, and has them as SVG.
    fn charts(&self, name: &str, rows: &[Row]) -> Result<Vec<String>> {
        let mut all = Vec::new();
        for which in CHARTS {
            let Some(sheet) = chart::draw(rows, name, which)? else { continue };
            let svg = sheet.svg();
            self.file(&format!("{name}-{}.svg", which.0), svg.as_bytes())?;
            let mut png = Vec::new();
            sheet.png(&mut png)?;
            self.file(&format!("{name}-{}.png", which.0), &png)?;
            all.push(svg);
        }
        Ok(all)
    }

    fn tables(&self, making: &Making, scene: &Path, name: &str) -> Result<Vec<Table>> {
        let reference = making.kept_file(name);
        let picture = making.folder.join("adapted.lux");
        let words = ["--to=D65".to_string(), "--quiet".into(), reference.display().to_string()];
        if let Err(said) = making.programs.run("vonkries", &words, &picture)? {
            return Err(Error::Invalid(said).in_file(scene));
        }
        let bench = Bench {
            programs: making.programs,
            limits: making.limits,
            folder: making.folder,
            picture: &picture,
            gain: self.gain,
        };
        Ok(vec![bench.encodings()?, bench.tones()?, filters::adaptations()?])
    }

    fn write(&self, sections: &[Section], tables: &[Table]) -> Result<()> {
        let rows: Vec<Row> = sections.iter().flat_map(|s| s.rows.clone()).collect();
        self.file("tradeoff.csv", table::csv(&rows).as_bytes())?;
        let head = format!(
            "Made by tradeoff of luxpipe {}: a run of more than {} s is its method's last; {}plans for a Delta E 2000 of {}, dark pixels \
             looked at up to {} times brighter.",
            env!("CARGO_PKG_VERSION"),
            self.seconds,
            self.width.map_or(String::new(), |w| format!("pictures {w} pixels wide; ")),
            self.tolerance,
            self.gain
        );
        self.file("tradeoff.html", page::page(&head, sections, tables).as_bytes())
    }

    fn file(&self, name: &str, bytes: &[u8]) -> Result<()> {
        let mut out = Output::create(Some(&self.out.join(name)), true)?;
        out.write_all(bytes).map_err(|e| out.error(e))?;
        out.finish()
    }
}

/// What the comment at a scene's head says.
fn about(path: &Path) -> Result<String> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path.display().to_string(), e))?;
    let head: Vec<&str> = text.lines().map_while(|l| l.strip_prefix('#')).map(str::trim).collect();
    Ok(head.join(" "))
}
