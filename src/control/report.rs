//! What a control did.

/// What became of a turn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct TurnReport {
    /// The stream's number of it.
    pub turn: u16,
    /// What it was allowed to take, in what the budget counts.
    pub budget: u32,
    /// Bytes of its datagrams.
    pub bytes: u32,
    /// Instructions, as far as the caller counted any.
    pub instructions: u32,
    /// Its datagrams.
    pub datagrams: u16,
    /// Levels of the step that it began with: its finest.
    pub finest: u16,
    /// Levels of its coarsest step.
    pub coarsest: u16,
    /// One of so many columns was kept.
    pub stride: u8,
    /// Columns that were cut off.
    pub cut: u32,
}
