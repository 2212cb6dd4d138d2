//! From a plan to one submission.

use super::Gpu;
use crate::plan::{Plan, Step};
use crate::timing::Timings;
use crate::{Error, Result};

/// Most workgroups along one axis of a dispatch that every adapter allows.
const AXIS: u32 = 65535;

/// Two time stamps a stage: begin and end.
struct Stamps {
    set: wgpu::QuerySet,
    stages: Vec<String>,
    capacity: usize,
}

impl Gpu {
    /// Executes a plan as one submission, timing each stage by time stamps.
    pub(crate) fn run(&self, plan: &Plan, timings: &Timings) -> Result<()> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("plan") });
        let mut stamps = self.stamps(plan.steps.len());
        for step in &plan.steps {
            match step {
                Step::Clear { buffer, .. } => encoder.clear_buffer(buffer.on_gpu(), 0, None),
                Step::Run { stage, kernel, groups, buffers } => {
                    let pipeline = self.pipeline(*kernel)?;
                    let entries: Vec<_> = buffers
                        .iter()
                        .enumerate()
                        .map(|(i, buffer)| wgpu::BindGroupEntry {
                            binding: i as u32,
                            resource: buffer.on_gpu().as_entire_binding(),
                        })
                        .collect();
                    let refused = |error: wgpu::Error| Error::Stage {
                        device: self.name(),
                        stage: stage.clone(),
                        reason: error.to_string(),
                    };
                    let descriptor =
                        wgpu::BindGroupDescriptor { label: Some(stage), layout: &pipeline.layout, entries: &entries };
                    let bind_group = self.checked(|| self.device.create_bind_group(&descriptor)).map_err(refused)?;
                    let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                        label: Some(stage),
                        timestamp_writes: stamps.as_mut().and_then(|stamps| stamps.next(stage)),
                    });
                    pass.set_pipeline(&pipeline.pipeline);
                    pass.set_bind_group(0, &bind_group, &[]);
                    // A kernel ignores the workgroups past its last that a rectangle of them may have.
                    let rows = groups.div_ceil(AXIS);
                    pass.dispatch_workgroups(groups.div_ceil(rows), rows, 1);
                }
            }
        }
        self.submit(encoder, plan, stamps, timings)
    }

    fn stamps(&self, steps: usize) -> Option<Stamps> {
        self.timestamp_period?;
        let capacity = steps.min(wgpu::QUERY_SET_MAX_QUERIES as usize / 2);
        let set = self.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("stage times"),
            ty: wgpu::QueryType::Timestamp,
            count: 2 * capacity.max(1) as u32,
        });
        Some(Stamps { set, stages: Vec::new(), capacity })
    }

    fn submit(
        &self,
        mut encoder: wgpu::CommandEncoder,
        plan: &Plan,
        stamps: Option<Stamps>,
        timings: &Timings,
    ) -> Result<()> {
        let extent = plan.extent();
        let stamps = stamps.filter(|stamps| !stamps.stages.is_empty());
        let resolved = stamps.as_ref().map(|stamps| {
            let count = 2 * stamps.stages.len() as u32;
            let buffer = self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("stage times"),
                size: 8 * u64::from(count),
                usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            });
            encoder.resolve_query_set(&stamps.set, 0..count, &buffer, 0);
            buffer
        });
        self.checked(|| self.queue.submit([encoder.finish()])).map_err(|error| Error::Stage {
            device: self.name(),
            stage: extent.clone(),
            reason: error.to_string(),
        })?;
        self.wait(&extent)?;
        if let (Some(stamps), Some(buffer), Some(period)) = (stamps, resolved, self.timestamp_period) {
            let mut ticks = vec![0u64; 2 * stamps.stages.len()];
            self.read("stage times", &buffer, bytemuck::cast_slice_mut(&mut ticks))?;
            for (stage, ticks) in stamps.stages.iter().zip(ticks.chunks_exact(2)) {
                timings.add(stage, ticks[1].wrapping_sub(ticks[0]) as f64 * f64::from(period) * 1e-6);
            }
        }
        Ok(())
    }
}

impl Stamps {
    fn next(&mut self, stage: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        if self.stages.len() == self.capacity {
            return None;
        }
        let first = 2 * self.stages.len() as u32;
        self.stages.push(stage.to_string());
        Some(wgpu::ComputePassTimestampWrites {
            query_set: &self.set,
            beginning_of_pass_write_index: Some(first),
            end_of_pass_write_index: Some(first + 1),
        })
    }
}
