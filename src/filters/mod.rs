//! The filters, one file each. A new one: its file here with one line in the list below, and its program in src/bin.

mod expmerge;
mod falsecolor;
mod pcompare;
mod pcond;
mod pdisplay;
mod pglare;
mod picinfo;
mod pjoin;
mod plocal;
mod pmix;
mod pplot;
mod ra_exr;
mod ra_loglv;
mod ra_pfm;
mod ra_pixlog;
mod ra_png;
mod ra_rgbe;
mod rad2scene;
mod relight;
mod spec2xyz;
mod specmat;
pub mod specplan;
mod specprobe;
pub mod spectrace;
mod vonkries;
mod xyz2rgb;

pub use expmerge::Expmerge;
pub use falsecolor::Falsecolor;
pub use pcompare::Pcompare;
pub use pcond::{Pcond, rewrite as pcond_arguments};
pub use pdisplay::Pdisplay;
pub use pglare::Pglare;
pub use picinfo::Picinfo;
pub use pjoin::Pjoin;
pub use plocal::Plocal;
pub use pmix::{Pmix, Term};
pub use pplot::Pplot;
pub use ra_exr::RaExr;
pub use ra_loglv::RaLoglv;
pub use ra_pfm::RaPfm;
pub use ra_pixlog::RaPixlog;
pub use ra_png::RaPng;
pub use ra_rgbe::RaRgbe;
pub use rad2scene::Rad2scene;
pub use relight::Relight;
pub use spec2xyz::Spec2xyz;
pub use specmat::Specmat;
pub use specplan::Specplan;
pub use specprobe::Specprobe;
pub use spectrace::Spectrace;
pub use vonkries::Vonkries;
pub use xyz2rgb::{Intent, Xyz2rgb};

use crate::color::Primaries;
use crate::display as medium;
use crate::filter::{Any, Entry, Filter};
use crate::stream::{Components, Header, Picture, Units, tristimulus, writer};
use crate::tone;
use crate::{Result, invalid, usage};

/// The filter of that name.
pub fn named(name: &str) -> Option<&'static dyn Any> {
    ALL.iter().copied().find(|f| f.name() == name)
}

/// The filter that passes one picture on as it is, in any `--format`.
pub const PASSES: &str = Pjoin::NAME;

/// A master is recorded before tone mapping, so that every display stays possible [Ward 2001].
fn check_master(header: &Header, force: bool) -> Result<()> {
    if header.units == Units::Display && !force {
        return invalid!(
            "the picture is display-referred; a master is recorded before tone mapping (--force records it)"
        );
    }
    Ok(())
}

/// Tone mapping begins with light of a scene.
fn check_scene(header: &Header) -> Result<()> {
    match header.units {
        Units::Display => invalid!("the picture is display-referred already (UNITS=display)"),
        Units::Relative => {
            invalid!("the picture is relative (UNITS=relative); a scene has cd/m2, say so with --units cd/m2")
        }
        _ => Ok(()),
    }
}

/// Black and white of a display by name, or by `--ldmax` and `--lddyn`.
fn display_range(display: Option<&medium::Display>, ldmax: f64, lddyn: f64) -> Result<tone::Display> {
    if let Some(d) = display {
        return Ok(tone::Display { max_cd_m2: d.white_cd_m2, min_cd_m2: d.black_cd_m2 });
    }
    if !(ldmax > 0.0 && ldmax <= 1e6) {
        return usage!("--ldmax {ldmax} is no luminance of a display's white");
    }
    if !(lddyn > 1.0 && lddyn <= 1e9) {
        return usage!("--lddyn {lddyn} is no contrast; it must be over 1");
    }
    Ok(tone::Display { max_cd_m2: ldmax, min_cd_m2: ldmax / lddyn })
}

/// An option that must be above 0 and finite where it is given.
fn positive(option: &str, value: Option<f64>) -> Result<()> {
    match value {
        Some(x) if !(x > 0.0 && x.is_finite()) => usage!("{option} {x} must be above 0"),
        _ => Ok(()),
    }
}

/// The picture as RGB of these primaries; without them RGB stays what it is, and all else becomes BT.709.
fn in_primaries(input: Box<dyn Picture>, to: Option<Primaries>) -> Result<Box<dyn Picture>> {
    match (input.header().components, to) {
        (Components::Rgb, None) => Ok(input),
        (Components::Rgb, to) if input.header().primaries == to => Ok(input),
        (_, to) => writer::to_rgb(tristimulus(input)?, to.unwrap_or(Primaries::BT709)),
    }
}

/// Every filter that a pipeline can run: `luxpipe`, the man pages and the tests walk this list.
pub static ALL: &[&dyn Any] = &[
    &Entry::<Spectrace>::NEW,
    &Entry::<Expmerge>::NEW,
    &Entry::<Spec2xyz>::NEW,
    &Entry::<Vonkries>::NEW,
    &Entry::<Pcond>::NEW,
    &Entry::<Plocal>::NEW,
    &Entry::<Xyz2rgb>::NEW,
    &Entry::<RaPng>::NEW,
    &Entry::<RaRgbe>::NEW,
    &Entry::<RaLoglv>::NEW,
    &Entry::<RaPixlog>::NEW,
    &Entry::<RaPfm>::NEW,
    &Entry::<RaExr>::NEW,
    &Entry::<Picinfo>::NEW,
    &Entry::<Rad2scene>::NEW,
    &Entry::<Specmat>::NEW,
    &Entry::<Specprobe>::NEW,
    &Entry::<Specplan>::NEW,
    &Entry::<Relight>::NEW,
    &Entry::<Pmix>::NEW,
    &Entry::<Pjoin>::NEW,
    &Entry::<Pcompare>::NEW,
    &Entry::<Pdisplay>::NEW,
    &Entry::<Pglare>::NEW,
    &Entry::<Falsecolor>::NEW,
    &Entry::<Pplot>::NEW,
];
