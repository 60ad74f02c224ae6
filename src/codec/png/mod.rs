//! PNG for displays: 8 or 16 bits a component, the display's curve, the colour space written in the file.
//!
//! Written: `sRGB` with its `gAMA` and `cHRM` for sRGB; for BT.709, Display P3 and BT.2020 with the sRGB, PQ or HLG
//! curve `cICP` (ITU-T H.273), with PQ and HLG and any primaries, those in `cHRM` where they have no number, and
//! `mDCV`, the display's range; for every curve but PQ and HLG an ICC profile (`iCCP`), and `gAMA` where the curve is a
//! power or nearly. The header's text (history, VIEW, WHITE, DISPLAY ...) is an `iTXt`, or `tEXt` where it is not
//! UTF-8, of keyword `luxpipe`.
//!
//! Read: every PNG, its first picture if it is animated, as linear RGB for a display. The colours are what the first of
//! `cICP`, `iCCP`, `sRGB`, `gAMA` and `cHRM` says that is there and understood, else sRGB, with a note. Transparency is
//! ignored, with a note. PQ is absolute: 1 is the white of the text's DISPLAY line, else 10,000 cd/m2; HLG is for that
//! white, else 1000 cd/m2. Rows flow one by one; an interlaced file is held whole, within `--memory`. Rows of over 2^24
//! pixels are refused, texts of over 1 MiB, other metadata of over 32 MiB.

mod colours;
mod icc;
mod pack;
mod read;
mod write;

use crate::codec::Format;
use crate::color::Primaries;
use crate::display::transfer::Transfer;

pub use write::{Clipped, Coding, write};

/// How to know and read it.
pub const FORMAT: Format = Format { name: "PNG", is: |first| first.starts_with(b"\x89PNG"), open: read::open };

/// Keyword of the text that holds a header.
const KEYWORD: &str = "luxpipe";

/// Colour primaries of ITU-T H.273 by their number; those written first.
const H273_PRIMARIES: [(u8, [f64; 8]); 7] = [
    (1, [0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290]),
    (12, [0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290]),
    (9, [0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290]),
    (5, [0.64, 0.33, 0.29, 0.60, 0.15, 0.06, 0.3127, 0.3290]),
    (6, [0.630, 0.340, 0.310, 0.595, 0.155, 0.070, 0.3127, 0.3290]),
    (11, [0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.314, 0.351]),
    (22, [0.630, 0.340, 0.295, 0.605, 0.155, 0.077, 0.3127, 0.3290]),
];

/// H.273's number for primaries that something else says, here cHRM.
const UNSPECIFIED: u8 = 2;

/// The numbers of a cICP chunk that say these colours. PQ and HLG can be said in no other way, whatever the primaries.
fn cicp(primaries: &Primaries, transfer: &Transfer) -> Option<[u8; 4]> {
    let same = |n: &[f64; 8]| Primaries::from_numbers(n).is_some_and(|p| p.distance(primaries) < icc::SAME);
    let known = H273_PRIMARIES[..3].iter().find(|p| same(&p.1)).map(|p| p.0);
    let hdr = matches!(transfer, Transfer::Pq | Transfer::Hlg);
    Some([known.or(hdr.then_some(UNSPECIFIED))?, transfer.cicp()?, 0, 1])
}

/// Primaries by the number of H.273; 7 has those of 6.
fn h273_primaries(code: u8) -> Option<Primaries> {
    let code = if code == 7 { 6 } else { code };
    H273_PRIMARIES.iter().find(|p| p.0 == code).and_then(|p| Primaries::from_numbers(&p.1))
}
