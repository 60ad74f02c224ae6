//! picinfo: what a picture is and what it holds.

use std::fmt::Write as _;

use clap::Args;
use serde::{Deserialize, Serialize};

use crate::clap_defaults;
use crate::color::Primaries;
use crate::error::printable;
use crate::filter::{Filter, Product, Run};
use crate::stream::output::Output;
use crate::stream::{Block, Components, Header, Picture};
use crate::{Error, Result};

/// Options of `picinfo`: none yet beyond the common ones.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields, rename_all = "kebab-case")]
pub struct Picinfo {}
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

    fn line(&self, name: &str) -> String {
        let mut line = if self.finite == 0 {
            format!("{name:<12}no finite value")
        } else {
            format!("{name:<12}{:.6e} to {:.6e}, mean {:.6e}", self.min, self.max, self.sum / self.finite as f64)
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
    const ABOUT: &'static str = "Print a picture's header, units, extremes and luminance histogram";
    const EXAMPLE: &'static str = "picinfo out/cornell.hdr";
    const FORMATS: bool = false;
    const SIGNS: bool = false;

    fn start(self, input: Option<Box<dyn Picture>>, _: &Run) -> Result<Product> {
        let mut picture = input.ok_or_else(|| Error::Usage("expected a picture".into()))?;
        let write = Box::new(move |out: &mut Output| {
            let text = report(&mut *picture)?;
            std::io::Write::write_all(out, text.as_bytes()).map_err(|e| out.error(e))
        });
        Ok(Product::Bytes { binary: false, write })
    }
}

fn report(picture: &mut dyn Picture) -> Result<String> {
    let header = picture.header().clone();
    let mut each = vec![Extremes::NONE; header.ncomp];
    let mut luminance = Extremes::NONE;
    let y = luminance_row(&header);
    let mut decades = [0u64; (*DECADES.end() - *DECADES.start()) as usize + 1];
    let mut dark = 0u64;
    let mut block = Block::default();
    while picture.next(&mut block)? {
        for pixel in block.data.chunks_exact(header.ncomp) {
            each.iter_mut().zip(pixel).for_each(|(e, x)| e.add(*x));
            let Some(y) = &y else { continue };
            let l: f64 = y.iter().zip(pixel).map(|(a, b)| a * f64::from(*b)).sum();
            luminance.add(l as f32);
            if l > 0.0 && l.is_finite() {
                let decade = (l.log10().floor() as i32).clamp(*DECADES.start(), *DECADES.end());
                decades[(decade - DECADES.start()) as usize] += 1;
            } else {
                dark += 1;
            }
        }
    }
    let mut text = describe(&header);
    let names = component_names(&header);
    for (name, extremes) in names.iter().zip(&each) {
        let _ = writeln!(text, "{}", extremes.line(name));
    }
    if y.is_some() {
        let _ = writeln!(text, "{}", luminance.line("luminance"));
        let total = (header.resolution.width * header.resolution.height) as f64;
        for (decade, count) in DECADES.zip(decades).filter(|(_, count)| *count > 0) {
            let share = 100.0 * count as f64 / total;
            let _ = writeln!(text, "  1e{decade:<+4} {share:6.2} % {}", "#".repeat((share / 2.0).ceil() as usize));
        }
        if dark > 0 {
            let _ = writeln!(text, "  none   {:6.2} %", 100.0 * dark as f64 / total);
        }
    }
    Ok(text)
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
        Components::Y => Some(vec![1.0]),
        Components::Xyz => Some(vec![0.0, 1.0, 0.0]),
        Components::Rgb => header.primaries.unwrap_or(Primaries::RADIANCE).to_xyz().map(|m| m.0[1].to_vec()),
        Components::Spectrum | Components::Stokes | Components::Response => None,
    }
}
