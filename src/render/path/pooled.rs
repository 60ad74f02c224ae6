//! Paths of pixels whose first surfaces are matt, pooled ([`crate::render::pool`]).

use glam::Vec3A;

use super::state::Way;
use super::{FIRST_PAIR, ROULETTE_FROM, Tracer};
use crate::render::lanes::Lanes;
use crate::render::pool::Pool;
use crate::render::sampler::Sampler;
use crate::render::trail::Trail;

/// Looks at the lamps for each path of a head: others' paths light it as well.
const LOOKS_A_PATH: u32 = 2;

// No path ends by lot at its head: whether it does would have to be part of its density.
const _: () = assert!(ROULETTE_FROM > 0);

impl Tracer<'_, ()> {
    /// Follows one path from the eye as a member of a pool; the trail is for what is the member's alone.
    pub(super) fn pooled(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        sampler: &Sampler,
        trail: &mut Trail,
        pool: &mut Pool,
    ) {
        let mut state = self.start((origin, direction), Way::Straight, trail.frame, sampler);
        let Some((meeting, lobe)) = self.arrive(&mut state, sampler, trail) else { return };
        if !lobe.kernel.is_matt() || lobe.kernel.transmits() {
            return self.beyond_first(state, &meeting, &lobe, sampler, trail);
        }
        // A black head sends no path, and must not count among those that might.
        if state.weight * self.outline.value(&state.outline) <= 0.0 {
            return;
        }
        trail.pooled();
        let looks = self.split;
        for k in 0..looks {
            let u = sampler.branch(k, looks).pair(FIRST_PAIR + 1);
            self.direct().look(&meeting, &lobe, state.weight / looks as f32, u, (None, None), trail);
        }
        let paths = (looks / LOOKS_A_PATH).max(1);
        state.share = 1.0 / paths as f32;
        state.weight *= state.share;
        pool.head(&meeting, state.weight);
        trail.fork();
        for k in 0..paths {
            let (mut state, sampler) = (state.clone(), sampler.branch(k, paths));
            trail.branch();
            let no_lot = 0.0;
            if !self.turn(&mut state, &meeting, &lobe, (no_lot, sampler.pair(FIRST_PAIR + 2)), trail) {
                continue;
            }
            let Some((there, lobe)) = self.arrive(&mut state, &sampler, trail) else { continue };
            if !there.matt {
                self.go(state, &there, &lobe, &sampler, trail);
                continue;
            }
            // From here on it is everybody's: what the head does to it, and how likely it was found, is said by the pool.
            let trail = pool.tail(&there);
            (state.weight, state.share, state.outline) = (lobe.factor, 1.0, Lanes::splat(1.0));
            self.tint(&mut state, &lobe.tint, trail);
            self.go(state, &there, &lobe, &sampler, trail);
        }
    }
}
