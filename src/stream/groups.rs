//! Rows of triples and planes of bytes, taken apart into groups that are coded together.

use super::rle::Planes;
use crate::simd::{self, GROUP, padded};

/// Turns triples into four planes: `code` gets a group of pixels and room for its bytes. A row's end is made up to a group by
/// zeros.
#[inline(always)]
pub fn encode(triples: &[f32], planes: &mut Planes, mut code: impl FnMut(&[f32; 3 * GROUP], [&mut [u8; GROUP]; 4])) {
    planes.iter_mut().for_each(|plane| plane.resize(triples.len() / 3, 0));
    simd::wide(
        #[inline(always)]
        || {
            let (groups, rest) = triples.as_chunks();
            let [a, b, c, d] = planes.each_mut().map(|plane| plane.as_chunks_mut());
            let targets = a.0.iter_mut().zip(b.0).zip(c.0).zip(d.0);
            for (group, (((a, b), c), d)) in groups.iter().zip(targets) {
                code(group, [a, b, c, d]);
            }
            if !rest.is_empty() {
                let mut bytes = [[0; GROUP]; 4];
                code(&padded(rest), bytes.each_mut());
                [a.1, b.1, c.1, d.1].into_iter().zip(&bytes).for_each(|(p, b)| p.copy_from_slice(&b[..p.len()]));
            }
        },
    );
}

/// Turns four planes into triples: `code` gets the bytes of a group and room for its pixels.
#[inline(always)]
pub fn decode(planes: &Planes, triples: &mut [f32], mut code: impl FnMut([&[u8; GROUP]; 4], &mut [f32; 3 * GROUP])) {
    simd::wide(
        #[inline(always)]
        || {
            let [a, b, c, d] = planes.each_ref().map(|plane| plane.as_chunks());
            let (groups, rest) = triples.as_chunks_mut();
            for ((((group, a), b), c), d) in groups.iter_mut().zip(a.0).zip(b.0).zip(c.0).zip(d.0) {
                code([a, b, c, d], group);
            }
            if !rest.is_empty() {
                let bytes = [a.1, b.1, c.1, d.1].map(padded);
                let mut group = [0.0; 3 * GROUP];
                code(bytes.each_ref(), &mut group);
                rest.copy_from_slice(&group[..rest.len()]);
            }
        },
    );
}
