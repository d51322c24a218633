//! A stage of the encoder, watched: a pin is high while it runs, and its cost is counted.

use core::convert::Infallible;

use embedded_hal::digital::OutputPin;

use super::stack;

/// A counter that runs all the time and may wrap around.
pub trait Clock: Copy {
    fn ticks(self) -> u32;
    /// How many of its units go into a tick.
    fn per_tick(self) -> u32;
    /// What it counts. Emulators are not cycle-accurate: they count instructions.
    fn unit(self) -> &'static str;
}

/// What a board brings.
pub trait Board {
    type Clock: Clock;
    type Pin: OutputPin<Error = Infallible>;
    fn clock(&self) -> Self::Clock;
    /// High while points are projected into the range image.
    fn project_pin(&mut self) -> &mut Self::Pin;
    /// High while the range image is coded.
    fn code_pin(&mut self) -> &mut Self::Pin;
    /// Runs `f` where no interrupt can add to its cost.
    fn undisturbed<R>(&mut self, f: impl FnOnce() -> R) -> R;
}

/// What a stage has cost so far.
pub struct Stage {
    ticks: u64,
    stack_bytes: usize,
}

impl Stage {
    pub const fn new() -> Self {
        Self { ticks: 0, stack_bytes: 0 }
    }

    /// Runs a part of the stage.
    pub fn run<B: Board, R>(&mut self, board: &mut B, pin: fn(&mut B) -> &mut B::Pin, part: impl FnOnce() -> R) -> R {
        let clock = board.clock();
        let mut ticks = 0;
        let Ok(()) = pin(board).set_high();
        let timed = || {
            let before = clock.ticks();
            let result = part();
            ticks = clock.ticks().wrapping_sub(before);
            result
        };
        let (result, stack_bytes) = board.undisturbed(|| stack::depth_of(timed));
        let Ok(()) = pin(board).set_low();
        self.ticks += u64::from(ticks);
        self.stack_bytes = self.stack_bytes.max(stack_bytes);
        result
    }

    /// Counts another's cost in.
    pub fn add(&mut self, other: &Self) {
        self.ticks += other.ticks;
        self.stack_bytes = self.stack_bytes.max(other.stack_bytes);
    }

    /// In the clock's unit.
    pub fn cost(&self, clock: impl Clock) -> u64 {
        self.ticks * u64::from(clock.per_tick())
    }

    pub const fn stack_bytes(&self) -> usize {
        self.stack_bytes
    }
}
