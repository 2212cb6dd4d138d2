//! From a plan to one submission.

use super::Gpu;
use crate::plan::{Plan, Step};
use crate::timing::Timings;
use crate::{Error, Result};

/// Most workgroups along one axis of a dispatch that every adapter allows.
const AXIS: u32 = 65535;

impl Gpu {
    /// Executes a plan as one submission, timing each stage by time stamps.
    pub(crate) fn run(&self, plan: &Plan, timings: &Timings) -> Result<()> {
        let mut encoder = self.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("plan") });
        let mut stamps = self.stamps();
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
                            resource: wgpu::BindingResource::Buffer(buffer.binding()),
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
        if let Some(stamps) = &stamps {
            stamps.resolve(&mut encoder);
        }
        let extent = plan.extent();
        self.checked(|| self.queue.submit([encoder.finish()])).map_err(|error| Error::Stage {
            device: self.name(),
            stage: extent.clone(),
            reason: error.to_string(),
        })?;
        self.wait_timed(&extent, stamps, timings)
    }
}
