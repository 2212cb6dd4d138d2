//! Time stamps: when each stage of a plan began and ended.

use super::Gpu;
use crate::Result;
use crate::timing::Timings;
use std::sync::{MutexGuard, PoisonError};

/// Stages that can be timed in one submission.
const CAPACITY: u32 = wgpu::QUERY_SET_MAX_QUERIES / 2;
/// Bytes of a time stamp.
const TICKS: u64 = 8;

/// Two time stamps a stage: begin and end. They are kept from plan to plan.
pub(super) struct Stamps {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    mapped: wgpu::Buffer,
    stages: Vec<String>,
}

impl Stamps {
    /// Where the pass that follows is to write when it begins and ends; nowhere if all places are taken.
    pub(super) fn next(&mut self, stage: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let number = self.stages.len() as u32;
        if number == CAPACITY {
            return None;
        }
        self.stages.push(stage.to_string());
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(2 * number),
            end_of_pass_write_index: Some(2 * number + 1),
        })
    }

    fn bytes(&self) -> u64 {
        2 * TICKS * self.stages.len() as u64
    }

    /// Takes the time stamps to where they can be read.
    pub(super) fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        if !self.stages.is_empty() {
            encoder.resolve_query_set(&self.set, 0..2 * self.stages.len() as u32, &self.resolved, 0);
            encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.mapped, 0, self.bytes());
        }
    }
}

impl Gpu {
    fn kept_stamps(&self) -> MutexGuard<'_, Vec<Stamps>> {
        self.stamps.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Time stamps for a plan, if the adapter has them.
    pub(super) fn stamps(&self) -> Option<Stamps> {
        self.timestamp_period?;
        let kept = self.kept_stamps().pop();
        Some(kept.unwrap_or_else(|| {
            let bytes = 2 * TICKS * u64::from(CAPACITY);
            let of = |usage| self.create_buffer("stage times", bytes, usage);
            Stamps {
                set: self.device.create_query_set(&wgpu::QuerySetDescriptor {
                    label: Some("stage times"),
                    ty: wgpu::QueryType::Timestamp,
                    count: 2 * CAPACITY,
                }),
                resolved: of(wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC),
                mapped: of(wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST),
                stages: Vec::new(),
            }
        }))
    }

    /// Waits for the plan that these time stamps are of, and adds its times.
    pub(super) fn wait_timed(&self, plan: &str, stamps: Option<Stamps>, timings: &Timings) -> Result<()> {
        let (Some(mut stamps), Some(period)) = (stamps, self.timestamp_period) else { return self.wait(plan) };
        if stamps.stages.is_empty() {
            self.wait(plan)?;
        } else {
            let mut ticks = vec![0u64; 2 * stamps.stages.len()];
            self.read_mapped(plan, &stamps.mapped, bytemuck::cast_slice_mut(&mut ticks))?;
            for (stage, ticks) in stamps.stages.iter().zip(ticks.chunks_exact(2)) {
                timings.add(stage, ticks[1].wrapping_sub(ticks[0]) as f64 * f64::from(period) * 1e-6);
            }
            stamps.stages.clear();
        }
        self.kept_stamps().push(stamps);
        Ok(())
    }
}
