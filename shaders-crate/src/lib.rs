//! SPIR-V entry points, one a stage, made from the list in `caustic_kernels::stages!`: an entry finds its index, hands its
//! buffers to the kernel and has no logic of its own.
//!
//! They exist for a GPU only: on the CPU, where `cargo test --workspace` builds this crate too, it is empty.
#![cfg(target_arch = "spirv")]
#![no_std]
#![allow(missing_docs)] // the entry points are documented where their bodies are

use caustic_kernels::exec::{Invocation, Single, SubgroupInvocation};
use caustic_kernels::gather::*;
use caustic_kernels::grid::{self, *};
use caustic_kernels::layout::*;
use caustic_kernels::probe::*;
use caustic_kernels::rivals::{self, *};
use caustic_kernels::sort::{self, *};
use caustic_kernels::trace::{self, *};
use caustic_kernels::{gather, probe, stages};
use glam::UVec3;
use spirv_std::spirv;

/// The type with which a shader sees a buffer.
macro_rules! buffer {
    (One $t:ty) => {
        &$t
    };
    (In $t:ty) => {
        &[$t]
    };
    (Out $t:ty) => {
        &mut [$t]
    };
    (InOut $t:ty) => {
        &mut [$t]
    };
}

macro_rules! entry_points {
    () => {};
    (each $name:ident = $entry:ident [$lanes:tt] ($($b:tt $arg:ident: $access:ident $t:ty),*) = $module:ident::$body:ident $([$($generic:tt),*])?;
     $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(local_invocation_id)] lane: UVec3,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            $module::$body$(::<$($generic),*>)?((group.y * groups.x + group.x) * $lanes + lane.x, $($arg),*);
        }
        entry_points! { $($rest)* }
    };
    (masked $name:ident = $entry:ident [$lanes:tt] ($($b:tt $arg:ident: $access:ident $t:ty),*) = $module:ident::$body:ident;
     $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(local_invocation_id)] lane: UVec3,
            #[spirv(spec_constant(id = 1, default = 63))] known: u32,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            $module::$body(Told(known), (group.y * groups.x + group.x) * $lanes + lane.x, $($arg),*);
        }
        entry_points! { $($rest)* }
    };
    (batch($registers:ty) $name:ident = $entry:ident [$lanes:tt] ($($b:tt $arg:ident: $access:ident $t:ty),*)
     = $module:ident::$body:ident; $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(local_invocation_id)] lane: UVec3,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            let index = (group.y * groups.x + group.x) * $lanes + lane.x;
            let mut single = Single { index, registers: <$registers>::default() };
            $module::$body(&mut single, $($arg),*);
        }
        entry_points! { $($rest)* }
    };
    (gather($container:ty) $name:ident = $entry:ident [$lanes:tt] ($($b:tt $arg:ident: $access:ident $t:ty),*)
     = $module:ident::$body:ident; $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(local_invocation_id)] lane: UVec3,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            $module::$body((group.y * groups.x + group.x) * $lanes + lane.x, <$container>::new(), $($arg),*);
        }
        entry_points! { $($rest)* }
    };
    (group($registers:ty; $shared:ty) $name:ident = $entry:ident [$lanes:tt]
     ($($b:tt $arg:ident: $access:ident $t:ty),*) = $module:ident::$body:ident; $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(local_invocation_id)] lane: UVec3,
            #[spirv(workgroup)] shared: &mut $shared,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            let mut lanes = Invocation { lanes: $lanes, lane: lane.x, registers: <$registers>::default() };
            $module::$body(&mut lanes, group.y * groups.x + group.x, shared, $($arg),*);
        }
        entry_points! { $($rest)* }
    };
    (columns($shared:ty) $name:ident = $entry:ident [$lanes:tt] ($($b:tt $arg:ident: $access:ident $t:ty),*)
     = $module:ident::$body:ident $([$($generic:tt),*])?; $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(local_invocation_id)] lane: UVec3,
            #[spirv(workgroup)] shared: &mut $shared,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            $module::$body$(::<$($generic),*>)?((group.y * groups.x + group.x) * $lanes + lane.x, lane.x, shared, $($arg),*);
        }
        entry_points! { $($rest)* }
    };
    (lanes($registers:ident; $shared:ty) $name:ident = $entry:ident [$lanes:tt] $($line:tt)*) => {
        entry_points! {
            group($registers<{ (SORT_BLOCK / $lanes) as usize }>; $shared) $name = $entry [$lanes] $($line)*
        }
    };
    (subgroups($registers:ident; $shared:ty) $name:ident = $entry:ident [$lanes:tt]
     ($($b:tt $arg:ident: $access:ident $t:ty),*) = $module:ident::$body:ident; $($rest:tt)*) => {
        #[spirv(compute(threads($lanes)))]
        pub fn $entry(
            #[spirv(workgroup_id)] group: UVec3,
            #[spirv(num_workgroups)] groups: UVec3,
            #[spirv(num_subgroups)] subgroups: u32,
            #[spirv(subgroup_id)] subgroup: u32,
            #[spirv(subgroup_local_invocation_id)] invocation: u32,
            #[spirv(workgroup)] shared: &mut $shared,
            $(#[spirv(storage_buffer, descriptor_set = 0, binding = $b)] $arg: buffer!($access $t)),*
        ) {
            let subgroup_bits = (($lanes as u32) / subgroups).trailing_zeros();
            let lane = (subgroup << subgroup_bits) + invocation;
            let registers = <$registers<{ (SORT_BLOCK / $lanes) as usize }>>::default();
            let mut lanes = SubgroupInvocation {
                invocation: Invocation { lanes: $lanes, lane, registers },
                subgroup,
                subgroup_bits,
            };
            $module::$body(&mut lanes, group.y * groups.x + group.x, shared, $($arg),*);
        }
        entry_points! { $($rest)* }
    };
}

stages!(entry_points);
