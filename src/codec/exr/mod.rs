//! OpenEXR: half or float channels by name, attributes by name, blocks of rows compressed one by one.
//!
//! **Colour.** RGB goes in channels R, G, B with `chromaticities`; XYZ in the same channels with the chromaticities
//! (1, 0), (0, 1), (0, 0) and white (1/3, 1/3), as the OpenEXR project's own XYZ.exr has it; luminance in Y.
//! `adoptedNeutral` is WHITE. `whiteLuminance` is what the value (1, 1, 1) has in cd/m2: 1 as a rule, more where a
//! half picture had to be scaled into the range of half, absent for display and relative pictures. `comments` keeps
//! the header's lines, history and exact numbers included; what the file itself states counts more than they do.
//!
//! **Range.** Half ends at 65504 and has fewer than 11 bits below 6.1e-5. No infinity is ever written.
//!
//! **Spectra** follow *An OpenEXR Layout for Spectral Images* (Fichet, Pacanowski, Wilkie, JCGT 10(3), 2021): channels
//! such as `S0.550,000000nm`, the centre for a bin, S0 to S3 being I, Q, U, V, with `spectralLayoutVersion` 1.0 and
//! `emissiveUnits` "W.m^-2.sr^-1", the string that pbrt, ART and colour-science write; it leaves out the "per nm" that
//! each value has, theirs as ours (W/sr/m2/nm). `polarisationHandedness` is "right": a positive V turns clockwise for
//! whoever looks toward the source; a "left" file is read with V negated. No RGB preview is written.
//!
//! **Reading.** Flat pictures by rows or tiles, half, float or whole numbers, every compression but HTJ2K; the first
//! of several parts, the largest of several sizes, the channels that are in no layer. Luminance and chroma (Y, RY, BY)
//! become RGB, linear between chroma samples. Not read: deep pictures, and subsampled channels under B44 or DWA.
//! Without `chromaticities` RGB is BT.709's, without `whiteLuminance` (and without a text of ours) numbers are taken
//! for cd/m2, with a note.
//!
//! The container is read and written here, with every size checked before anything is allocated; blocks are packed and
//! unpacked by the `exr` crate.

mod chroma;
mod coder;
mod head;
mod read;
mod spectral;
mod write;

pub use write::{Compression, Depth, Options, write};

use crate::codec::Format;

/// How to know and read it.
pub const FORMAT: Format = Format { name: "OpenEXR", is: |first| first.starts_with(&head::MAGIC), open: read::open };
