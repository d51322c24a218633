//! What a piece of work takes: the fastest run's time, on the clock and of the processor (which what else the machine does
//! changes less); and energy, where the machine counts it (RAPL).

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Energy counters step once in a millisecond: so long a piece of work is needed to tell.
const ENERGY_TIME: Duration = Duration::from_millis(400);

#[derive(Clone, Copy)]
pub struct Cost {
    pub ns: u64,
    /// Of all threads together.
    pub cpu_ns: u64,
    /// Of the whole processor, as `perf` has it: mean of many runs.
    pub energy_uj: Option<f64>,
}

impl Cost {
    pub fn json(self) -> Value {
        json!({ "ns": self.ns, "cpu_ns": self.cpu_ns, "energy_uj": self.energy_uj })
    }

    /// Of two pieces of work, one after the other.
    pub fn and(self, other: Self) -> Self {
        Self {
            ns: self.ns + other.ns,
            cpu_ns: self.cpu_ns + other.cpu_ns,
            energy_uj: self.energy_uj.zip(other.energy_uj).map(|(one, other)| one + other),
        }
    }

    /// Of the rest of a piece of work.
    pub fn beyond(self, part: Self) -> Self {
        Self {
            ns: self.ns.saturating_sub(part.ns),
            cpu_ns: self.cpu_ns.saturating_sub(part.cpu_ns),
            energy_uj: self.energy_uj.zip(part.energy_uj).map(|(whole, part)| (whole - part).max(0.0)),
        }
    }
}

/// Runs the work so many times, at least once; gives the last result.
pub fn measure<T>(runs: usize, mut work: impl FnMut() -> T) -> (T, Cost) {
    let mut timed = || {
        let (start, cpu_start) = (Instant::now(), cpu_ns());
        let result = black_box(work());
        (result, start.elapsed().as_nanos() as u64, cpu_ns() - cpu_start)
    };
    let (mut result, mut ns, mut cpu_ns) = timed();
    for _ in 1..runs {
        let (next, next_ns, next_cpu_ns) = timed();
        (result, ns, cpu_ns) = (next, ns.min(next_ns), cpu_ns.min(next_cpu_ns));
    }
    let energy_uj = if runs > 1 { energy(&mut work) } else { None };
    (result, Cost { ns, cpu_ns, energy_uj })
}

/// What the processor has spent on this process.
fn cpu_ns() -> u64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as u64 * 1_000_000_000 + time.tv_nsec as u64
}

/// Microjoules of one run, where there is a counter.
fn energy<T>(work: &mut impl FnMut() -> T) -> Option<f64> {
    let counters = Counters::find()?;
    let (before, start, mut runs) = (counters.read()?, Instant::now(), 0_u32);
    while start.elapsed() < ENERGY_TIME {
        black_box(work());
        runs += 1;
    }
    Some((counters.read()? - before) / f64::from(runs)).filter(|&uj| uj > 0.0)
}

/// One a processor package.
struct Counters(Vec<PathBuf>);

impl Counters {
    fn find() -> Option<Self> {
        let folder = std::fs::read_dir("/sys/class/powercap").ok()?;
        let is_package = |path: &Path| {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            name.strip_prefix("intel-rapl:").is_some_and(|rest| !rest.contains(':'))
        };
        let packages = folder.flatten().map(|entry| entry.path()).filter(|path| is_package(path));
        let found: Vec<_> = packages.map(|path| path.join("energy_uj")).collect();
        (!found.is_empty()).then_some(Self(found))
    }

    fn read(&self) -> Option<f64> {
        self.0.iter().map(|path| std::fs::read_to_string(path).ok()?.trim().parse::<f64>().ok()).sum()
    }
}
