//! Which rows hold returns: nibbles that say which groups of eight rows changed, then what changed in those.

use super::band::{Band, GROUPS};

/// Contexts of nibbles: 32 of changed groups, 48 of changed rows.
pub(crate) const CONTEXTS: usize = CHANGES_FIRST as usize + 48;
const CHANGES_FIRST: u16 = 32;
/// Most nibbles of a band's column, in whole rounds of four.
pub(crate) const NIBBLES_MAX: usize = 20;

/// Forward and inverse in one: `code` is given a context and, in the forward direction, the nibble to code there; it
/// gives the nibble. `sets` are filled in, which changes nothing in the forward direction.
#[inline]
pub(crate) fn walk<E>(
    band: &mut Band,
    sets: &mut [u8; GROUPS],
    mut code: impl FnMut(u16, u8) -> Result<u8, E>,
) -> Result<(), E> {
    let mut changed = 0;
    for (group, (set, before)) in sets.iter().zip(&band.sets).enumerate() {
        changed |= u8::from(set != before) << group;
    }
    let low = code(2 * u16::from(band.changed & 15), changed & 15)?;
    let high = code(2 * u16::from(band.changed >> 4) + 1, changed >> 4)?;
    changed = low | high << 4;
    for (group, (set, before)) in sets.iter_mut().zip(band.sets).enumerate() {
        if changed >> group & 1 == 0 {
            *set = before;
            continue;
        }
        let change = *set ^ before;
        let context = |nibble: u8, kind: u16| CHANGES_FIRST + 3 * u16::from(nibble) + kind;
        let low = code(context(before & 15, 0), change & 15)?;
        let high = code(context(before >> 4, if low == 0 { 2 } else { 1 }), change >> 4)?;
        *set = before ^ (low | high << 4);
    }
    band.changed = changed;
    band.sets = *sets;
    Ok(())
}
