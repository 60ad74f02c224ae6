//! One scene: its reference, each method as hard as its time allows, each plan on the same paths.

use std::path::Path;

use crate::stream::spool::Limits;
use crate::tradeoff::child::{Programs, Ran, file_word};
use crate::tradeoff::judge::{Errors, Seen};
use crate::tradeoff::methods::{METHODS, Method, PATH};
use crate::tradeoff::picture;
use crate::tradeoff::reference::{Making, Reference};
use crate::tradeoff::table::{Kind, Row};
use crate::{Error, Result};

/// What is tried on each scene.
pub struct Wanted {
    /// Names of [`METHODS`].
    pub methods: Vec<String>,
    /// Words of [`crate::tradeoff::methods::PLANS`].
    pub plans: Vec<String>,
    /// A run that takes longer is its method's last.
    pub seconds: f64,
    /// Delta E 2000 that `specplan` plans for.
    pub tolerance: f64,
    /// Paths a pixel that plans are compared by.
    pub samples: u32,
}

/// A scene at work.
pub struct Subject<'a> {
    /// Its file.
    pub path: &'a Path,
    /// Its file's name without suffix.
    pub name: &'a str,
    /// How its reference is made.
    pub making: &'a Making<'a>,
    /// What is tried.
    pub wanted: &'a Wanted,
}

/// A picture, and what it cost.
struct Shot {
    seen: Seen,
    ran: Ran,
}

impl Subject<'_> {
    fn programs(&self) -> &Programs {
        self.making.programs
    }

    fn limits(&self) -> &Limits {
        self.making.limits
    }

    fn row(&self, kind: Kind, name: &str, setting: &str) -> Row {
        Row {
            scene: self.name.into(),
            kind,
            name: name.into(),
            setting: setting.into(),
            seconds: f64::NAN,
            planning_s: f64::NAN,
            relative_rmse: f64::NAN,
            delta_e: [f64::NAN; 2],
            peak_mb: None,
            note: String::new(),
            shown: None,
        }
    }

    /// Renders with these options, split at blanks.
    fn shot(&self, options: &str, more: &[String]) -> Result<std::result::Result<Shot, String>> {
        let file = self.making.folder.join("shot.lux");
        let mut words: Vec<String> = options.split_whitespace().map(String::from).collect();
        words.extend_from_slice(more);
        words.extend(self.making.width.map(|w| format!("--width={w}")));
        words.push(file_word(self.path));
        Ok(match self.programs().run("spectrace", &words, &file)? {
            Ok(ran) => Ok(Shot { seen: Seen::read(&file, self.limits())?, ran }),
            Err(said) => Err(said),
        })
    }

    /// All rows of the scene.
    pub fn rows(&self, tell: &mut dyn FnMut(&Row)) -> Result<Vec<Row>> {
        let reference = self.making.of(self.path, self.name)?;
        let width = reference.seen.header.resolution.width;
        let mut first = self.row(Kind::Reference, "reference", if reference.fresh { "made now" } else { "kept" });
        first.relative_rmse = reference.noise[0];
        first.delta_e = [reference.noise[1], f64::NAN];
        let errors = Errors { map: vec![0.0; width * reference.seen.header.resolution.height], ..Errors::default() };
        first.shown = Some(self.shown(&reference.seen, &errors, &reference)?);
        tell(&first);
        let mut rows = vec![first];
        let text = std::fs::read_to_string(self.path).map_err(|e| Error::io(self.path.display().to_string(), e))?;
        let filled = text.parse::<toml::Table>().is_ok_and(|t| t.contains_key("media"));
        let wanted = |m: &&Method| self.wanted.methods.iter().any(|w| w == m.name) && (filled || !m.media_only);
        for method in METHODS.iter().filter(wanted) {
            rows.extend(self.by_method(method, &reference, None, tell)?);
        }
        rows.extend(self.by_plans(&reference, tell)?);
        Ok(rows)
    }

    fn shown(&self, seen: &Seen, errors: &Errors, reference: &Reference) -> Result<[Vec<u8>; 2]> {
        let width = seen.header.resolution.width;
        let white = reference.seen.white();
        Ok([picture::shown(&seen.xyz, width, white, reference.white_y)?, picture::error_map(&errors.map, width)?])
    }

    /// What a run came to: its cost, and its errors against `want`, under the reference's white.
    fn fill(&self, row: &mut Row, shot: &Shot, want: &Seen, planning_s: f64, reference: &Reference) -> Result<()> {
        let errors = want.errors_of(&shot.seen, reference.white_y, self.making.gain)?;
        (row.planning_s, row.seconds) = (planning_s, shot.ran.seconds + planning_s);
        row.relative_rmse = errors.relative_rmse;
        row.delta_e = [errors.rms, errors.p95];
        row.peak_mb = shot.ran.peak_mb;
        row.shown = Some(self.shown(&shot.seen, &errors, reference)?);
        Ok(())
    }

    /// Ever more work, until a run takes its seconds. A plan's file, with the seconds that it took, makes it a row of that plan.
    fn by_method(
        &self,
        method: &Method,
        reference: &Reference,
        plan: Option<(&str, f64)>,
        tell: &mut dyn FnMut(&Row),
    ) -> Result<Vec<Row>> {
        let mut rows: Vec<Row> = Vec::new();
        let more: Vec<String> = plan.iter().map(|p| format!("--plan={}", p.0)).collect();
        let name = plan.map_or(method.name.to_string(), |_| format!("{} by specplan", method.name));
        for effort in method.efforts {
            let mut row = self.row(Kind::Method, &name, effort);
            let method_word = format!("--method {} {effort} --seed 1", method.name);
            let shot = match self.shot(&method_word, &more)? {
                Ok(shot) => shot,
                Err(said) => {
                    row.note = said;
                    tell(&row);
                    rows.push(row);
                    return Ok(rows);
                }
            };
            self.fill(&mut row, &shot, &reference.seen, plan.map_or(0.0, |p| p.1), reference)?;
            row.note =
                shot.ran.said.lines().map(|l| l.trim_start_matches("spectrace: ")).collect::<Vec<_>>().join("; ");
            tell(&row);
            let last = row.seconds > self.wanted.seconds;
            rows.iter_mut().for_each(|r| r.shown = None);
            rows.push(row);
            if last {
                break;
            }
        }
        Ok(rows)
    }

    /// What paths carry, against full bands on the same paths; and the plan that specplan chooses as a method of its own.
    fn by_plans(&self, reference: &Reference, tell: &mut dyn FnMut(&Row)) -> Result<Vec<Row>> {
        let mut rows = Vec::new();
        if self.wanted.plans.is_empty() {
            return Ok(rows);
        }
        let paths = format!("--samples {} --seed 1", self.wanted.samples);
        let full = match self.shot(&paths, &[])? {
            Ok(full) => full,
            Err(said) => {
                let mut row = self.row(Kind::Plan, "full bands", &paths);
                row.note = said;
                return Ok(vec![row]);
            }
        };
        for plan in &self.wanted.plans {
            let mut row = self.row(Kind::Plan, plan, &paths);
            let (options, planning_s) = match self.planned(plan)? {
                Ok(planned) => planned,
                Err(said) => {
                    row.note = said;
                    tell(&row);
                    rows.push(row);
                    continue;
                }
            };
            match self.shot(&paths, std::slice::from_ref(&options))? {
                Ok(shot) => self.fill(&mut row, &shot, &full.seen, planning_s, reference)?,
                Err(said) => row.note = said,
            }
            tell(&row);
            rows.push(row);
            if let (true, Some(file)) = (plan == "specplan", options.strip_prefix("--plan="))
                && let Some(path) = METHODS.iter().find(|m| m.name == PATH)
            {
                rows.extend(self.by_method(path, reference, Some((file, planning_s)), tell)?);
            }
        }
        Ok(rows)
    }

    /// The option that renders by a plan, and the seconds that planning took; or why there is none.
    fn planned(&self, plan: &str) -> Result<std::result::Result<(String, f64), String>> {
        if let Some(count) = plan.strip_prefix("bands") {
            return Ok(Ok((format!("--bands={count}"), 0.0)));
        }
        let file = self.making.folder.join(format!("{plan}.plan"));
        let mut words = vec![file_word(self.path)];
        match plan {
            "specplan" => words.push(format!("--tolerance={}", self.wanted.tolerance)),
            model => words.extend([format!("--model={model}"), "--pilot=0".into()]),
        }
        words.push(format!("--gain={}", self.making.gain));
        let ran = self.programs().run("specplan", &words, &file)?;
        Ok(ran.map(|r| (format!("--plan={}", file.display()), r.seconds)))
    }
}
