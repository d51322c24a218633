//! The probabilities, all of them in flash. `cargo run --release --features std --example train_fast` made `priors.bin`
//! from the three scans of KITTI's object benchmark.
//!
//! | bytes | what |
//! |---|---|
//! | 4 x [`CELLS`] | the table of each cell, for steps of 1 and 2, 3 to 39, 40 to 79, and 80 levels and more |
//! | [`TABLES`] x 64 x 2 | frequencies of a table's symbols, out of 4096 |
//! | [`CONTEXTS`] x 16 x 2 | frequencies of a context's nibbles |

use super::band::{CELLS, EDGES_FROM};
use super::occupancy::CONTEXTS;
use super::rans::{Share, TOTAL};
use super::symbol::{ESCAPE, SYMBOLS};

/// Tables of symbols that the cells share.
pub(crate) const TABLES: usize = 96;
/// Kinds of steps.
pub(crate) const KINDS: usize = 4;
/// Values of a nibble.
pub(crate) const NIBBLES: usize = 16;
const FREQUENCIES_AT: usize = KINDS * CELLS;
const NIBBLES_AT: usize = FREQUENCIES_AT + TABLES * SYMBOLS * 2;
/// Length of the file.
pub(crate) const LEN: usize = NIBBLES_AT + CONTEXTS * NIBBLES * 2;

static PRIORS: [u8; LEN] = *include_bytes!("priors.bin");

/// The kind of steps of so many levels.
pub(crate) const fn kind(step_levels: u16) -> usize {
    match step_levels {
        0..3 => 0,
        3..40 => 1,
        40..EDGES_FROM => 2,
        _ => 3,
    }
}

/// Tables by cell.
pub(crate) fn tables(step_levels: u16) -> &'static [u8; CELLS] {
    let (kinds, _) = PRIORS.as_chunks::<CELLS>();
    &kinds[kind(step_levels)]
}

/// Frequency of a symbol; 0 where the table has it not.
pub(crate) const fn frequency(table: usize, symbol: usize) -> u16 {
    at(FREQUENCIES_AT + 2 * (table * SYMBOLS + symbol))
}

/// Frequency of a nibble.
pub(crate) const fn nibble_frequency(context: usize, nibble: usize) -> u16 {
    at(NIBBLES_AT + 2 * (context * NIBBLES + nibble))
}

const fn at(at: usize) -> u16 {
    PRIORS[at] as u16 | (PRIORS[at + 1] as u16) << 8
}

/// First token of the nibbles: those before are table x 64 + symbol.
pub(crate) const NIBBLES_FIRST: u16 = (TABLES * SYMBOLS) as u16;
/// The token of what is certain.
pub(crate) const CERTAIN: u16 = SHARES_LEN as u16 - 1;
/// A power of two, so that no token is beyond.
const SHARES_LEN: usize = (TABLES * SYMBOLS + CONTEXTS * NIBBLES + 1).next_power_of_two();

static SHARES: [Share; SHARES_LEN] = shares();

#[expect(clippy::large_stack_arrays, reason = "on the compiler's stack")]
const fn shares() -> [Share; SHARES_LEN] {
    let mut shares = [Share::CERTAIN; SHARES_LEN];
    let mut table = 0;
    while table < TABLES {
        let (mut start, mut symbol) = (0, 0);
        while symbol < SYMBOLS {
            let frequency = frequency(table, symbol);
            shares[table * SYMBOLS + symbol] = Share::new(start, frequency);
            start += frequency;
            symbol += 1;
        }
        assert!(start as u32 == TOTAL, "frequencies of symbols");
        table += 1;
    }
    let mut context = 0;
    while context < CONTEXTS {
        let (mut start, mut nibble) = (0, 0);
        while nibble < NIBBLES {
            let frequency = nibble_frequency(context, nibble);
            shares[NIBBLES_FIRST as usize + context * NIBBLES + nibble] = Share::new(start, frequency);
            start += frequency;
            nibble += 1;
        }
        assert!(start as u32 == TOTAL, "frequencies of nibbles");
        context += 1;
    }
    shares
}

/// The share of a token.
#[inline(always)]
pub(crate) fn share(token: u16) -> &'static Share {
    &SHARES[usize::from(token) & (SHARES_LEN - 1)]
}

/// By table: symbols from this one on are escaped.
pub(crate) static LIMITS: [u8; TABLES] = {
    let mut limits = [0; TABLES];
    let mut table = 0;
    while table < TABLES {
        let mut limit = 0;
        while limit < ESCAPE as usize && frequency(table, limit) > 0 {
            limit += 1;
        }
        limits[table] = limit as u8;
        table += 1;
    }
    limits
};

#[cfg(feature = "std")]
pub(crate) use inverse::{Inverse, inverse};

#[cfg(feature = "std")]
mod inverse {
    use std::sync::LazyLock;
    use std::vec::Vec;

    use super::super::rans::Part;
    use super::{CONTEXTS, NIBBLES, SYMBOLS, TABLES, TOTAL, frequency, nibble_frequency};

    const SLOTS: usize = TOTAL as usize;

    /// A table of symbols, as a decoder looks it up.
    #[derive(Debug, Clone)]
    pub(crate) struct Table {
        /// Start x 2^16 + frequency by symbol.
        parts: [u32; SYMBOLS],
        /// By slot.
        symbols: [u8; SLOTS],
    }

    impl Table {
        fn new(frequencies: impl Fn(usize) -> u16) -> Self {
            let mut table = Self { parts: [0; SYMBOLS], symbols: [0; SLOTS] };
            let mut start = 0;
            for (symbol, part) in table.parts.iter_mut().enumerate() {
                let frequency = u32::from(frequencies(symbol));
                *part = start << 16 | frequency;
                table.symbols[start as usize..(start + frequency) as usize].fill(symbol as u8);
                start += frequency;
            }
            table
        }

        /// Symbol, start and frequency of a slot.
        #[inline(always)]
        pub(crate) fn symbol(&self, slot: u32) -> Part {
            let symbol = self.symbols[slot as usize & (SLOTS - 1)];
            let part = self.parts[usize::from(symbol) & (SYMBOLS - 1)];
            (u16::from(symbol), part >> 16, part & 0xFFFF)
        }
    }

    /// What a decoder looks up: 420 KB, made when it is first needed.
    #[derive(Debug)]
    pub(crate) struct Inverse {
        tables: Vec<Table>,
        /// Of what is certain.
        pub(crate) certain: Table,
        nibbles: Vec<Nibbles>,
    }

    pub(crate) fn inverse() -> &'static Inverse {
        static INVERSE: LazyLock<Inverse> = LazyLock::new(Inverse::new);
        &INVERSE
    }

    impl Inverse {
        fn new() -> Self {
            let table = |table| Table::new(|symbol| frequency(table, symbol));
            let certain = Table::new(|symbol| if symbol == 0 { TOTAL as u16 } else { 0 });
            let nibbles = (0..CONTEXTS).map(Nibbles::new).collect();
            Self { tables: (0..TABLES).map(table).collect(), certain, nibbles }
        }

        /// The table of a number.
        #[inline(always)]
        pub(crate) fn table(&self, number: u8) -> &Table {
            self.tables.get(usize::from(number)).unwrap_or(&self.certain)
        }

        /// Nibble, start and frequency of a slot.
        #[inline(always)]
        pub(crate) fn nibble(&self, context: usize, slot: u32) -> Part {
            let Nibbles { starts, first } = &self.nibbles[context];
            let mut nibble = usize::from(first[slot as usize / SLOTS_A_HINT % HINTS]);
            while u32::from(starts[(nibble + 1) & 15]) <= slot && nibble < NIBBLES - 1 {
                nibble += 1;
            }
            let (start, end) = (u32::from(starts[nibble & 15]), u32::from(starts[(nibble & 15) + 1]));
            (nibble as u16, start, end - start)
        }
    }

    /// Slots that share a hint at their nibble.
    const SLOTS_A_HINT: usize = 16;
    const HINTS: usize = SLOTS / SLOTS_A_HINT;

    /// A table of nibbles.
    #[derive(Debug, Clone)]
    struct Nibbles {
        /// Starts by nibble, and the end.
        starts: [u16; NIBBLES + 1],
        /// The nibble of the first slot of so many.
        first: [u8; HINTS],
    }

    impl Nibbles {
        fn new(context: usize) -> Self {
            let starts = nibble_starts(context);
            let nibble = |slot: usize| starts[1..].iter().filter(|start| usize::from(**start) <= slot).count() as u8;
            Self { starts, first: core::array::from_fn(|hint| nibble(hint * SLOTS_A_HINT)) }
        }
    }

    fn nibble_starts(context: usize) -> [u16; NIBBLES + 1] {
        let mut starts = [0; NIBBLES + 1];
        for nibble in 0..NIBBLES {
            starts[nibble + 1] = starts[nibble] + nibble_frequency(context, nibble);
        }
        starts
    }
}
