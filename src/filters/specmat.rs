//! specmat: spectra of materials and sources to XYZ and RGB: absolute, adjusted by Eq. (7), and relative to the dominant
//! source, for renderers of three channels [Ward 2001, "Relative Color Approximation"].

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::{Args, ValueEnum, ValueHint};
use serde::{Deserialize, Serialize};

use crate::color::relative::{self, Grid};
use crate::color::{Cat, Mat3, Primaries, Relative, White, Xy, adapt, matrix};
use crate::filter::{Filter, Product, Run};
use crate::options::{quote, words};
use crate::scene::palette::Palette;
use crate::stream::output::Output;
use crate::stream::{Components, Picture, Units, picture};
use crate::units::RADIANCE_EFFICACY;
use crate::{Error, Result, clap_defaults, invalid, usage};

/// What to write.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[value(rename_all = "lowercase")]
pub enum Layout {
    /// Columns for the eye
    Table,
    /// The same columns with nine decimals
    Csv,
    /// Materials and lights for Radiance
    Radiance,
    /// Materials and lights for another renderer of three channels
    Toml,
    /// Delta E 2000 of the approximation against full spectra, for one to three bounces
    Errors,
}

/// Options of `specmat`.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Specmat {
    /// A material beside those of LIST: a built-in spectrum, a .csv file or a number, with a name of its own as NAME=SPECTRUM
    #[arg(long, value_name = "SPECTRUM")]
    pub material: Vec<String>,
    /// A source likewise: A, lamp=lamp.csv, '{ blackbody = 2856 }'
    #[arg(long, value_name = "SPECTRUM")]
    pub source: Vec<String>,
    /// Working space of relative colours: BT.2020 unless --literal, whose is BT.709
    #[arg(long, value_name = "PRIMARIES")]
    pub space: Option<Primaries>,
    /// Materials keep their absolute RGB under a white source, as the paper words it. Each bounce then tints once more: mean
    /// Delta E 2000 14 under A at two bounces, against 1.0 without this option
    #[arg(long)]
    pub literal: bool,
    /// Source to take as dominant, in place of the one with the largest share
    #[arg(long, value_name = "NAME")]
    pub dominant: Option<String>,
    /// White of adjusted colours
    #[arg(long, value_name = "WHITE", default_value = "D65")]
    pub to: White,
    /// Sensor matrix of adjusted colours
    #[arg(long, value_enum, value_name = "CAT", default_value = "cmccat2000")]
    pub cat: Cat,
    /// What to write
    #[arg(long, value_enum, value_name = "FORMAT", default_value = "table")]
    pub format: Layout,
    /// Close the work: read the picture rendered with the relative colours from standard input, multiply by (Rw,Gw,Bw), write
    /// XYZ with the dominant source as WHITE
    #[arg(long, conflicts_with = "format")]
    pub finish: bool,
    /// Materials and sources: TOML, or CSV lines kind,name,spectrum[,share]
    #[arg(value_name = "LIST", value_hint = ValueHint::FilePath)]
    pub list: Option<PathBuf>,
}
clap_defaults!(Specmat);

/// A dominant share under this warns.
const DOMINANT: f64 = 0.8;

/// A source with its numbers.
struct Lamp {
    name: String,
    power: Vec<f64>,
    /// Y = 1.
    xyz: [f64; 3],
    white: Xy,
    share: Option<f64>,
    luminance: Option<f64>,
}

/// Everything that the outputs draw on.
struct Work {
    grid: Grid,
    space: Primaries,
    relative: Relative,
    materials: Vec<(String, Vec<f64>)>,
    lamps: Vec<Lamp>,
    dominant: usize,
    to: Xy,
}

impl Filter for Specmat {
    const NAME: &'static str = "specmat";
    const ABOUT: &'static str =
        "Material and source spectra to XYZ and RGB: absolute, adjusted, relative to the dominant source";
    const EXAMPLE: &'static str = "specmat --material cc_ohta_05_blue_flower --source A --source B --source D65
specmat --format radiance palettes/office.toml > office.mat
specmat --finish palettes/office.toml < rendered.hdr | vonkries --to D65 > office.lux";
    const READS: bool = false;
    const FORMATS: bool = false;

    /// The closing steps need a picture.
    fn reads(&self) -> bool {
        self.finish
    }

    fn start(self, input: Option<Box<dyn Picture>>, run: &Run) -> Result<Product> {
        let work = self.work(run)?;
        if let Some(input) = input {
            return work.finish(input);
        }
        let text = match self.format {
            Layout::Table => aligned(&work.table(self.cat, 5)),
            Layout::Csv => work.table(self.cat, 9).iter().map(|row| row.join(",") + "\n").collect(),
            Layout::Radiance => self.radiance(&work),
            Layout::Toml => self.toml(&work),
            Layout::Errors => aligned(&work.errors(self.cat)?),
        };
        let head =
            if self.format == Layout::Radiance || self.format == Layout::Toml { String::new() } else { work.head() };
        let write = Box::new(move |out: &mut Output| {
            std::io::Write::write_all(out, (head + &text).as_bytes()).map_err(|e| out.error(e))
        });
        Ok(Product::Bytes { binary: false, write })
    }
}

impl Specmat {
    fn work(&self, run: &Run) -> Result<Work> {
        let mut palette = match &self.list {
            Some(path) => Palette::load(path)?,
            None if self.material.is_empty() && self.source.is_empty() => {
                return usage!("expected a LIST, or --material and --source");
            }
            None => Palette::default(),
        };
        for word in &self.material {
            palette.add_material_word(word).map_err(|e| e.within("--material"))?;
        }
        for word in &self.source {
            palette.add_source_word(word).map_err(|e| e.within("--source"))?;
        }
        let settled = palette.settle_shares();
        settled
            .map_err(|e| self.list.as_ref().map_or(e.to_string(), |p| format!("{}: {e}", p.display())))
            .map_err(Error::Invalid)?;
        let to = self.to.xy().ok_or_else(|| Error::Usage("--to needs a white, not 'header'".into()))?;
        let dominant = palette.dominant(self.dominant.as_deref()).map_err(|e| e.within("--dominant"))?;
        let grid = Grid::cie1931()?;
        let mut lamps = Vec::new();
        for s in &palette.sources {
            let power = grid.sample(&s.spectrum);
            let xyz = grid.xyz(&power, &[]);
            let dark = || Error::Invalid(format!("source '{}' has no visible light", s.name));
            let white = Xy::of(xyz).ok_or_else(dark)?;
            let white = s.white.unwrap_or(white);
            lamps.push(Lamp { name: s.name.clone(), power, xyz, white, share: s.share, luminance: s.luminance });
        }
        let space = self.space.unwrap_or(default_space(self.literal));
        let relative = Relative::new(&space, lamps[dominant].xyz, self.literal)?;
        let materials = palette.materials.iter().map(|m| (m.name.clone(), grid.sample(&m.reflectance))).collect();
        let work = Work { grid, space, relative, materials, lamps, dominant, to };
        work.remark(self.dominant.is_some(), run);
        Ok(work)
    }

    /// The command that closes the work, its list of sources as given.
    fn closing(&self) -> String {
        let own = Specmat { finish: true, format: Layout::Table, material: Vec::new(), ..self.clone() };
        let list: Vec<String> = words(&own, false).iter().map(|w| quote(w)).collect();
        format!("specmat {}", list.join(" "))
    }

    /// Radiance materials. Its lamps have radiance / 179 lm/W.
    fn radiance(&self, work: &Work) -> String {
        let mut text = work.head();
        let (steps, both) = if self.literal { ("", "This") } else { ("times (Rw,Gw,Bw), ", "The first two") };
        let cat = if self.cat == Cat::Cmccat2000 { String::new() } else { format!(" --cat {}", self.cat.name()) };
        let _ =
            writeln!(text, "# The picture rendered with these holds relative colours. Closing steps, in this order:");
        let _ = writeln!(text, "# {steps}XYZ with WHITE set, and only then adaptation:");
        let _ = writeln!(text, "#   rpict ... | {} | vonkries --to {}{cat} > picture.lux", self.closing(), self.to);
        let _ = writeln!(text, "# {both} as one matrix on the picture's RGB:");
        for row in work.relative.finish().0 {
            let _ = writeln!(text, "#   {}", numbers(row, 7));
        }
        for (name, rgb) in work.relative_materials() {
            let _ = writeln!(text, "\nvoid plastic {name}\n0\n0\n5 {} 0 0", numbers(rgb, 7));
        }
        for lamp in &work.lamps {
            let rgb = work.relative.source(lamp.xyz);
            let (scale, what) = match lamp.luminance {
                Some(l) => (l / RADIANCE_EFFICACY, format!("{l} cd/m2")),
                None => (
                    1.0,
                    format!(
                        "{RADIANCE_EFFICACY} cd/m2: multiply by the radiance you want, cd/m2 / {RADIANCE_EFFICACY}"
                    ),
                ),
            };
            let _ =
                writeln!(text, "\n# {what}\nvoid light {}\n0\n0\n3 {}", lamp.name, numbers(rgb.map(|c| c * scale), 7));
        }
        text
    }

    fn toml(&self, work: &Work) -> String {
        let mut text = work.head();
        let list = |v: &[f64]| format!("[{}]", v.iter().map(|x| format!("{x:.9}")).collect::<Vec<_>>().join(", "));
        let lamp = &work.lamps[work.dominant];
        let _ = writeln!(text, "\n[working]\nspace = \"{}\"\nprimaries = {:?}", work.space, work.space.numbers());
        let _ = writeln!(text, "dominant = \"{}\"\nwhite_xy = [{}]\nliteral = {}", lamp.name, lamp.white, self.literal);
        let _ = writeln!(text, "white_rgb = {}", list(&work.relative.white));
        let rows = work.relative.finish().0.map(|r| list(&r)).join(", ");
        let _ = writeln!(
            text,
            "to_xyz = [{rows}]   # of the rendered picture, (Rw,Gw,Bw) within\nfinish = {}",
            toml::Value::String(self.closing())
        );
        for (name, rgb) in work.relative_materials() {
            let _ = writeln!(text, "\n[materials.\"{name}\"]\nrgb = {}", list(&rgb));
        }
        for lamp in &work.lamps {
            let _ = writeln!(text, "\n[lights.\"{}\"]\nrgb = {}", lamp.name, list(&work.relative.source(lamp.xyz)));
            for (key, value) in [("share", lamp.share), ("luminance", lamp.luminance)] {
                let _ = value.map(|v| writeln!(text, "{key} = {v:?}"));
            }
        }
        text
    }
}

/// The paper computes in the display's space; what is divided by the source wants a wide one.
fn default_space(literal: bool) -> Primaries {
    if literal { Primaries::BT709 } else { Primaries::BT2020 }
}

impl Work {
    /// Notes on what the numbers cannot tell.
    fn remark(&self, chosen: bool, run: &Run) {
        let lamp = &self.lamps[self.dominant];
        match lamp.share {
            Some(share) if share < DOMINANT => run.notes.add(format!(
                "the dominant source {} has a share of {share:.2}; under {DOMINANT} the colours of the others count: see --format errors",
                lamp.name
            )),
            None if !chosen && self.lamps.len() > 1 => run.notes.add(format!(
                "no source has a share or lumens; {} is taken as dominant, --dominant names another",
                lamp.name
            )),
            _ => {}
        }
        let outside = |rgb: &[f64; 3], top: f64| rgb.iter().any(|c| *c < 0.0 || *c > top);
        let materials = self.relative_materials().filter(|(_, rgb)| outside(rgb, 1.0)).map(|m| m.0.as_str());
        let lamps = self.lamps.iter().filter(|l| outside(&self.relative.source(l.xyz), f64::INFINITY));
        let names: Vec<&str> = materials.chain(lamps.map(|l| l.name.as_str())).collect();
        if !names.is_empty() {
            run.notes.add(format!(
                "outside 0 to 1 in {} and written as they are: {}; a renderer that clamps them needs a wider --space",
                self.space,
                names.join(", ")
            ));
        }
    }

    fn relative_materials(&self) -> impl Iterator<Item = (&String, [f64; 3])> {
        let power = &self.lamps[self.dominant].power;
        self.materials.iter().map(|(name, r)| (name, self.relative.material(self.grid.xyz(power, &[r]))))
    }

    /// The facts that all numbers below stand on, as comments.
    fn head(&self) -> String {
        let lamp = &self.lamps[self.dominant];
        let share = lamp.share.map_or(String::new(), |s| format!(", share {s:.3} of the luminous flux"));
        let p = self.space.numbers();
        let literal = if self.relative.literal { ", literal: materials absolute, source white" } else { "" };
        format!(
            "# working space {}, primaries {}{literal}\n# dominant source {} (x {:.5}, y {:.5}{share}); in the working space (Rw,Gw,Bw) = {}\n",
            self.space,
            p.map(|x| x.to_string()).join(" "),
            lamp.name,
            lamp.white.x,
            lamp.white.y,
            numbers(self.relative.white, 7)
        )
    }

    /// A row a source, then a row a material and source. Relative colours of a source are beside the dominant one, of a
    /// material under the source of its row.
    fn table(&self, cat: Cat, digits: usize) -> Vec<Vec<String>> {
        let columns = "kind name source x y X Y Z R_abs G_abs B_abs R_adj G_adj B_adj R_rel G_rel B_rel share";
        let mut rows = vec![columns.split(' ').map(String::from).collect::<Vec<_>>()];
        let to_709 = Primaries::BT709.from_xyz().unwrap_or(Mat3::IDENTITY); // these primaries span an area
        let mut push = |kind: &str, name: &str, lamp: &Lamp, xyz: [f64; 3], relative: Option<[f64; 3]>| {
            let adapted = adapt::von_kries(cat, lamp.white, self.to, 1.0).ok().map(|m| to_709.times(&m).apply(xyz));
            let xy = Xy::of(xyz).map(|p| vec![p.x, p.y]);
            let cell = |x: &f64| format!("{x:.digits$}");
            let cells = |v: Option<&[f64]>, n: usize| match v {
                Some(v) => v.iter().map(cell).collect(),
                None => vec!["-".to_string(); n],
            };
            let mut row = [kind, name, &lamp.name].map(String::from).to_vec();
            row.extend(cells(xy.as_deref(), 2));
            row.extend(cells(Some(&xyz), 3));
            row.extend(cells(Some(&to_709.apply(xyz)), 3));
            row.extend(cells(adapted.as_ref().map(|v| &v[..]), 3));
            row.extend(cells(relative.as_ref().map(|v| &v[..]), 3));
            row.push(lamp.share.map_or("-".into(), |s| cell(&s)));
            rows.push(row);
        };
        for lamp in &self.lamps {
            push("source", &lamp.name, lamp, lamp.xyz, Some(self.relative.source(lamp.xyz)));
        }
        for (name, reflectance) in &self.materials {
            for lamp in &self.lamps {
                let xyz = self.grid.xyz(&lamp.power, &[reflectance]);
                let own = Relative::new(&self.space, lamp.xyz, self.relative.literal).ok();
                push("material", name, lamp, xyz, own.map(|r| r.material(xyz)));
            }
        }
        rows
    }

    /// For the light of each source, one to three bounces.
    fn errors(&self, cat: Cat) -> Result<Vec<Vec<String>>> {
        if self.materials.is_empty() {
            return invalid!("no material; expected at least one to reflect light");
        }
        let dominant = &self.lamps[self.dominant];
        let materials: Vec<Vec<f64>> = self.materials.iter().map(|m| m.1.clone()).collect();
        let mut rows = vec!["light bounces colours mean_dE00 95%_dE00 max_dE00".split(' ').map(String::from).collect()];
        for lamp in &self.lamps {
            for bounces in 1..=3 {
                let lights = [&lamp.power[..], &dominant.power[..]];
                let views = (cat, dominant.white, self.to);
                let spread = relative::spread(&self.grid, &self.relative, lights, &materials, bounces, views)?;
                let Some(s) = spread else { continue };
                let mut row = vec![lamp.name.clone(), bounces.to_string(), s.count.to_string()];
                row.extend([s.mean, s.p95, s.max].map(|x| format!("{x:.3}")));
                rows.push(row);
            }
        }
        Ok(rows)
    }

    /// The closing steps: whatever primaries its header states, the picture's RGB is that of the working space.
    fn finish(self, input: Box<dyn Picture>) -> Result<Product> {
        let mut header = input.header().clone();
        if header.components != Components::Rgb || header.units == Units::Display {
            return invalid!(
                "--finish expects RGB scene light as a renderer of three channels leaves it, the picture is {} in {}",
                header.components,
                header.units
            );
        }
        if header.adapted.is_some() {
            return invalid!("the picture has been adapted already; --finish comes first");
        }
        let m = self.relative.finish().to_f32();
        header.become_tristimulus(Components::Xyz, header.units);
        header.white = Some(self.lamps[self.dominant].white);
        Ok(Product::Picture(picture::map(input, header, move |pixels| matrix::multiply_rows(&m, pixels))))
    }
}

/// Three numbers with this many decimals.
fn numbers(v: [f64; 3], digits: usize) -> String {
    v.map(|x| format!("{x:.digits$}")).join(" ")
}

/// Rows as columns: names to the left, numbers to the right.
fn aligned(rows: &[Vec<String>]) -> String {
    let width = |j: usize| rows.iter().map(|r| r[j].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..rows.first().map_or(0, Vec::len)).map(width).collect();
    let is_text = |j: usize| rows.get(1).is_some_and(|r| r[j].parse::<f64>().is_err() && r[j] != "-");
    let mut text = String::new();
    for row in rows {
        let cells = row.iter().enumerate().map(|(j, c)| {
            if is_text(j) { format!("{c:<w$}", w = widths[j]) } else { format!("{c:>w$}", w = widths[j]) }
        });
        text += cells.collect::<Vec<_>>().join(" ").trim_end();
        text.push('\n');
    }
    text
}
