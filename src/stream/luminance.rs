//! Any picture as one number a pixel: its luminance, or what a picture of Y holds.

use crate::Result;
use crate::stream::{Components, Picture, picture, tristimulus};

/// The picture as Y in the units it has (cd/m2 from spectra).
pub fn luminance(input: Box<dyn Picture>) -> Result<Box<dyn Picture>> {
    if input.header().components == Components::Y {
        return Ok(input);
    }
    let input = tristimulus(input)?;
    let mut header = input.header().clone();
    header.become_tristimulus(Components::Y, header.units);
    header.ncomp = 1;
    Ok(picture::map_across(input, header, |from, to| {
        to.iter_mut().zip(from.chunks_exact(3)).for_each(|(y, xyz)| *y = xyz[1]);
    }))
}
