//! The CPU and a GPU side by side: every stage runs on both, and what it writes is compared word by word.

use crate::cpu::{Cpu, lock_read};
use crate::gpu::Gpu;
use crate::kernel::Kernel;
use crate::plan::{Plan, Step};
use crate::timing::Timings;
use crate::{Buffer, Difference, Result};
use serde::Serialize;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// What comparing one kernel's results found, over all its runs.
#[derive(Clone, Debug, Serialize)]
pub struct StageComparison {
    /// The kernel's entry point.
    pub stage: &'static str,
    /// How often it ran.
    pub runs: u32,
    /// What was compared and found.
    #[serde(flatten)]
    pub difference: Difference,
}

pub(crate) struct Comparisons {
    /// From this stage on the GPU keeps its own results.
    from: Option<Kernel>,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    rows: Vec<StageComparison>,
    /// Whether `from` was reached.
    alone: bool,
}

impl Comparisons {
    pub(crate) fn new(from: Option<Kernel>) -> Self {
        Self { from, state: Mutex::default() }
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn report(&self) -> Vec<StageComparison> {
        self.state().rows.clone()
    }

    /// Executes a plan on both, a step at a time.
    pub(crate) fn run(&self, plan: &Plan, cpu: &Cpu, gpu: &Gpu, timings: &Timings) -> Result<()> {
        for step in &plan.steps {
            let single = Plan::of(step.clone());
            cpu.run(&single, timings)?;
            gpu.run(&single, timings)?;
            if let Step::Run { kernel, buffers, .. } = step {
                self.compare(kernel.kernel, buffers, gpu)?;
            }
        }
        Ok(())
    }

    fn compare(&self, kernel: Kernel, buffers: &[Buffer], gpu: &Gpu) -> Result<()> {
        let mut state = self.state();
        state.alone |= self.from == Some(kernel);
        let mut difference = Difference::default();
        for (buffer, binding) in buffers.iter().zip(kernel.bindings()).filter(|(_, b)| b.access.writes()) {
            let expected = lock_read(buffer.on_cpu());
            let mut found = vec![0u32; expected.len()];
            gpu.read(buffer.name(), buffer.on_gpu(), bytemuck::cast_slice_mut(&mut found))?;
            let compared = Difference::between(binding.name, binding.words, &expected, &found);
            if !state.alone && !compared.is_none() {
                gpu.write(buffer.on_gpu(), bytemuck::cast_slice(&expected));
            }
            difference.add(compared);
        }
        let stage = kernel.entry_point();
        match state.rows.iter_mut().find(|row| row.stage == stage) {
            Some(row) => {
                row.runs += 1;
                row.difference.add(difference);
            }
            None => state.rows.push(StageComparison { stage, runs: 1, difference }),
        }
        Ok(())
    }
}
