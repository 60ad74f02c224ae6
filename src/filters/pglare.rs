//! pglare: what glares in a picture of an eye's field of view, and how much (see `glare`).

use std::ffi::OsString;

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::filter::{Filter, Product, Run};
use crate::glare::Field;
use crate::glare::findings::{self, Findings, Settings, Threshold};
use crate::glare::indices::Veil;
use crate::options::Numbers;
use crate::stream::output::Output;
use crate::stream::upright::upright;
use crate::stream::{Block, Picture, Units, luminance};
use crate::view::View;
use crate::{Error, Result, invalid, usage};

/// A threshold up to this is a factor, as evalglare has it.
const LARGEST_FACTOR: f64 = 100.0;

/// Options of `pglare`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Pglare {
    /// Brighter pixels glare: above 100 a luminance in cd/m2, else times the mean of the picture or of --task
    #[arg(short = 'b', long, value_name = "CD_M2|FACTOR", default_value_t = 2000.0)]
    pub threshold: f64,
    /// Glaring pixels within half this angle, in radians, are one source
    #[arg(short = 'r', long, value_name = "RAD", default_value_t = 0.2)]
    pub search_radius: f64,
    /// Brighter parts of a source count as sources of their own
    #[arg(short = 'Y', long, value_name = "CD_M2", default_value_t = 50000.0, conflicts_with = "no_peaks")]
    pub peak: f64,
    /// Keep peaks in their sources
    #[arg(short = 'x', long)]
    pub no_peaks: bool,
    /// What the eye looks at, for a --threshold that is a factor: pixels from the left and from the bottom, and the angle across,
    /// in radians
    #[arg(long, value_name = "X,Y,RAD")]
    pub task: Option<Numbers>,
    /// Vertical illuminance at the eye as measured, in lux, where the picture does not show all of the field
    #[arg(short = 'i', long, value_name = "LUX")]
    pub illuminance: Option<f64>,
    /// Luminance of the background
    #[arg(short = 'q', long, value_enum, value_name = "HOW", default_value = "indirect")]
    pub background: Background,
    /// Formula of the veiling luminance
    #[arg(long, value_enum, value_name = "FORMULA", default_value = "stiles-holladay")]
    pub glare: Formula,
    /// Age of the observer in years
    #[arg(long, value_name = "YEARS", default_value_t = 25.0)]
    pub age: f64,
    /// With --glare cie: pigment of the eye, 0 black, 0.5 brown, 1.2 light blue
    #[arg(long, value_name = "P", default_value_t = 0.5)]
    pub pigment: f64,
    /// How the picture was seen, in place of its VIEW line, such as "-vta -vh 180 -vv 180"
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true)]
    pub view: Option<String>,
    /// Print one JSON object instead of text
    #[arg(long, help_heading = "Running")]
    pub json: bool,
}
clap_defaults!(Pglare);

/// What counts as the background's luminance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Background {
    /// Illuminance without the sources' part, over pi: the CIE's
    #[value(alias = "0")]
    Indirect,
    /// Mean of the pixels that do not glare
    #[value(alias = "1")]
    Mean,
    /// Illuminance over pi
    #[value(alias = "2")]
    Total,
}

/// Formula of the veiling luminance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Formula {
    /// 10 E / angle^2, with age
    StilesHolladay,
    /// The CIE's general equation, from 0.1 degree, with age and pigment
    Cie,
}

impl Pglare {
    fn check(&self) -> Result<()> {
        for (option, value) in [("--threshold", self.threshold), ("--peak", self.peak)] {
            super::positive(option, Some(value))?;
        }
        super::positive("--illuminance", self.illuminance)?;
        if !(0.0..=3.2).contains(&self.search_radius) {
            return usage!("--search-radius {} must be 0 to 3.14 radians", self.search_radius);
        }
        if !(0.0..=120.0).contains(&self.age) || !(0.0..=2.0).contains(&self.pigment) {
            return usage!("--age must be 0 to 120 years, --pigment 0 to 2");
        }
        Ok(())
    }

    fn view(&self, picture: &dyn Picture) -> Result<View> {
        match &self.view {
            Some(text) => View::parse(text)
                .ok_or_else(|| Error::Usage(format!("--view {text}: expected such as \"-vta -vh 180 -vv 180\""))),
            None => View::of(picture.header()).ok_or_else(|| {
                Error::Invalid(
                    "no VIEW line says how the picture was seen; give such as --view \"-vta -vh 180 -vv 180\"".into(),
                )
            }),
        }
    }

    fn settings(&self) -> Result<Settings> {
        let task = match &self.task {
            None => None,
            Some(_) if self.threshold > LARGEST_FACTOR => {
                return usage!("--task goes with a --threshold that is a factor, such as 5");
            }
            Some(Numbers(n)) => Some(
                <[f64; 3]>::try_from(&n[..])
                    .map_err(|_| Error::Usage("--task needs three numbers: x,y,angle".into()))?,
            ),
        };
        Ok(Settings {
            threshold: if self.threshold > LARGEST_FACTOR {
                Threshold::Fixed(self.threshold)
            } else {
                Threshold::Times(self.threshold, task)
            },
            radius_rad: self.search_radius,
            peak_cd_m2: if self.no_peaks { f64::INFINITY } else { self.peak },
            illuminance_lux: self.illuminance,
            background: match self.background {
                Background::Indirect => findings::Background::Indirect,
                Background::Mean => findings::Background::Mean,
                Background::Total => findings::Background::Total,
            },
            veil: match self.glare {
                Formula::StilesHolladay => Veil::StilesHolladay,
                Formula::Cie => Veil::Cie,
            },
            age_years: self.age,
            pigment: self.pigment,
        })
    }
}

impl Filter for Pglare {
    const NAME: &'static str = "pglare";
    const ABOUT: &'static str = "Print illuminance at the eye, glare sources, glare indices (DGP, DGI, UGR ...) and veiling luminance of a fisheye picture";
    const EXAMPLE: &'static str = "rpict -vta -vh 180 -vv 180 -x 1024 -y 1024 office.oct | pglare\npglare --threshold 5 --age 60 --json fisheye.hdr";
    const FORMATS: bool = false;
    const SIGNS: bool = false;

    fn rewrite(args: Vec<OsString>) -> Result<Vec<OsString>> {
        Ok(evalglare_words(args))
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let input = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        self.check()?;
        if input.header().units == Units::Display || input.header().units == Units::Relative {
            return invalid!(
                "the picture is in {}; glare needs cd/m2, a picture no tone mapping has seen",
                input.header().units
            );
        }
        let settings = self.settings()?;
        let view = self.view(&*input)?;
        let limits = run.options.limits();
        let mut input = upright(luminance(input)?, &limits)?;
        if input.header().units != Units::CdM2 {
            return invalid!(
                "the picture is in {}; glare needs cd/m2, say so with --units cd/m2",
                input.header().units
            );
        }
        let r = input.header().resolution;
        let bytes = 4 * r.width as u64 * r.height as u64;
        if bytes > limits.memory {
            let needed = bytes.div_ceil(1 << 20);
            return Err(Error::Unsupported(format!("the picture takes {needed} MB; allow it with --memory")));
        }
        let notes = run.notes.clone();
        let write = Box::new(move |out: &mut Output| {
            let mut field = Field::new(view, r.width, r.height);
            let mut block = Block::default();
            while input.next(&mut block)? {
                field.add(&block.data);
            }
            let found = Findings::of(&field, &settings)?;
            if field.replaced > 0 {
                notes.add(format!("{} pixels that were negative or not finite count as black", field.replaced));
            }
            let share = found.hemisphere();
            if share < 0.98 && self.illuminance.is_none() {
                notes.add(format!(
                    "the picture shows {:.0} % of the hemisphere, and the rest counts as black; --illuminance gives what was measured",
                    100.0 * share
                ));
            }
            let text = if self.json { format!("{}\n", found.json()) } else { found.text() };
            std::io::Write::write_all(out, text.as_bytes()).map_err(|e| out.error(e))
        });
        Ok(Product::Bytes { binary: false, write })
    }
}

/// evalglare's command line in today's words: `-t X Y RAD`, `-vta -vh H -vv V`; `-d`, `-y` and `-C` are what is done anyway.
fn evalglare_words(args: Vec<OsString>) -> Vec<OsString> {
    let (mut words, mut view) = (Vec::new(), Vec::new());
    let mut args = args.into_iter();
    while let Some(word) = args.next() {
        let text = word.to_string_lossy().into_owned();
        let mut next =
            |n: usize| (0..n).filter_map(|_| args.next()).map(|w| w.to_string_lossy().into_owned()).collect();
        match text.as_str() {
            "-d" | "-y" => {}
            "-C" => drop::<Vec<String>>(next(1)),
            "-t" | "-T" => words.push(format!("--task={}", next(3).join(",")).into()),
            "-vh" | "-vv" => view.push(format!("{text} {}", next(1).join(" "))),
            _ if text.len() == 4 && text.starts_with("-vt") => view.push(text),
            _ => words.push(word),
        }
    }
    if !view.is_empty() {
        words.insert(1, format!("--view={}", view.join(" ")).into());
    }
    words
}
