//! Which bodies a place is in.

/// Numbers of media, that of the body entered last first: a byte each, up to eight bodies within bodies; of more the outermost are
/// forgotten.
///
/// ```
/// use luxpipe::medium::Inside;
/// let milk = Inside::default().entered(3).entered(7);
/// assert!(milk.latest_first().eq([7, 3]) && milk.left(3).latest_first().eq([7]));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Inside(u64);

impl Inside {
    /// Media at most.
    pub const MOST: usize = 254;

    /// In none.
    #[inline]
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// In one more body.
    #[inline]
    pub fn entered(self, medium: u32) -> Inside {
        Inside(self.0 << 8 | u64::from(medium + 1))
    }

    /// Out of the last entered one with this medium; the same where there is none.
    #[inline]
    pub fn left(self, medium: u32) -> Inside {
        let mut shift = 0;
        let mut rest = self.0;
        while rest != 0 {
            if rest & 0xff == u64::from(medium + 1) {
                let after = self.0 & ((1 << shift) - 1);
                let before = if shift == 56 { 0 } else { self.0 >> (shift + 8) << shift };
                return Inside(before | after);
            }
            (rest, shift) = (rest >> 8, shift + 8);
        }
        self
    }

    /// Beyond a surface with this medium behind its front, come from before it or from behind.
    #[inline]
    pub fn beyond(self, interior: Option<u32>, from_front: bool) -> Inside {
        match interior {
            None => self,
            Some(medium) if from_front => self.entered(medium),
            Some(medium) => self.left(medium),
        }
    }

    /// A body with this medium is among them.
    #[inline]
    pub fn holds(self, medium: u32) -> bool {
        self.latest_first().any(|m| m == medium)
    }

    /// All of them.
    #[inline]
    pub fn latest_first(self) -> impl Iterator<Item = u32> {
        let mut rest = self.0;
        std::iter::from_fn(move || {
            let medium = (rest & 0xff).checked_sub(1)?;
            rest >>= 8;
            Some(medium as u32)
        })
    }
}
