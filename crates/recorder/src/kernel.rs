//! Calling the recorded bodies, by the list of stages.

use crate::counts::Accesses;
use crate::groups::Groups;
use crate::output::Outputs;
use bytemuck::{Pod, TransparentWrapper};
use caustic_device::{Access, Kernel};
use caustic_kernels_recorded::exec::{Input, Many};
use caustic_kernels_recorded::gather::*;
use caustic_kernels_recorded::grid::{self, *};
use caustic_kernels_recorded::layout::*;
use caustic_kernels_recorded::probe::*;
use caustic_kernels_recorded::rivals::{self, *};
use caustic_kernels_recorded::sort::{self, *};
use caustic_kernels_recorded::trace::{self, *};
use caustic_kernels_recorded::{gather, probe, stages};

macro_rules! kernels {
    ($($shape:ident $(($($detail:tt)*))? $name:ident = $entry:ident [$lanes:tt]
       ($($b:tt $arg:ident: $access:ident $t:ty),*) = $module:ident::$body:ident $([$($generic:tt),*])?;)*) => {
        /// Runs the recorded workgroups of a kernel. `buffers` has the words of its bindings.
        pub(crate) fn run(kernel: Kernel, groups: &Groups, buffers: &[&[u32]], outputs: &Outputs) -> Accesses {
            let addresses = addresses(kernel, buffers, outputs);
            match kernel {
                $(Kernel::$name => {
                    $(let $arg = bind!($access $t, $b, buffers, outputs);)*
                    run!($shape $(($($detail)*))?, groups, &addresses, $lanes, $module::$body $([$($generic),*])?, $($access $arg),*)
                })*
            }
        }
    };
}

/// The address by which accesses to each binding know it.
fn addresses(kernel: Kernel, buffers: &[&[u32]], outputs: &Outputs) -> Vec<Option<usize>> {
    let bindings = kernel.bindings().iter().zip(buffers).enumerate();
    let address = |(b, (binding, words)): (usize, (&caustic_device::Binding, &&[u32]))| match binding.access {
        Access::One => None,
        Access::In => Some(words.as_ptr().addr()),
        Access::Out | Access::InOut => outputs.address(b),
    };
    bindings.map(address).collect()
}

/// The records of a buffer that a kernel reads.
fn input<T: Pod>(words: &[u32]) -> &Input<T> {
    Input::wrap_ref(bytemuck::cast_slice::<u32, T>(words))
}

/// The type with which a recorded body sees a buffer.
macro_rules! bind {
    (One $t:ty, $b:tt, $buffers:ident, $outputs:ident) => {
        &bytemuck::cast_slice::<u32, $t>($buffers[$b])[0]
    };
    (In $t:ty, $b:tt, $buffers:ident, $outputs:ident) => {
        input::<$t>($buffers[$b])
    };
    (Out $t:ty, $b:tt, $buffers:ident, $outputs:ident) => {
        $outputs.write::<$t>($b)
    };
    (InOut $t:ty, $b:tt, $buffers:ident, $outputs:ident) => {
        $outputs.write::<$t>($b)
    };
}

/// Hands a buffer to a body: each call has its own handle of what is written.
macro_rules! pass {
    (Out $arg:ident) => {
        &mut $arg.clone()
    };
    (InOut $arg:ident) => {
        &mut $arg.clone()
    };
    ($access:ident $arg:ident) => {
        $arg
    };
}

macro_rules! run {
    (each, $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident $([$($generic:tt),*])?, $($access:ident $arg:ident),*) => {
        $groups.each($at, $lanes, |i| $module::$body$(::<$($generic),*>)?(i, $(pass!($access $arg)),*))
    };
    (masked, $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident, $($access:ident $arg:ident),*) => {
        $groups.each($at, $lanes, |i| $module::$body(Told($groups.known), i, $(pass!($access $arg)),*))
    };
    // Phases without barriers: a lane alone.
    (batch($registers:ty), $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident, $($access:ident $arg:ident),*) => {
        $groups.each($at, $lanes, |i| {
            let mut alone = Many { first: i, registers: &mut [<$registers>::default()], order: &[0] };
            $module::$body(&mut alone, $(pass!($access $arg)),*);
        })
    };
    (gather($container:ty), $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident, $($access:ident $arg:ident),*) => {
        $groups.each($at, $lanes, |i| $module::$body(i, <$container>::new(), $(pass!($access $arg)),*))
    };
    (columns($shared:ty), $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident $([$($generic:tt),*])?,
     $($access:ident $arg:ident),*) => {
        $groups.columns::<$shared>($at, $lanes, |i, lane, shared| {
            $module::$body$(::<$($generic),*>)?(i, lane, shared, $(pass!($access $arg)),*)
        })
    };
    (group($registers:ty; $shared:ty), $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident,
     $($access:ident $arg:ident),*) => {
        run!(in 1, $registers, $shared, $groups, $at, $lanes, $module::$body, $($access $arg),*)
    };
    (lanes($registers:ident; $shared:ty), $groups:expr, $at:expr, $lanes:tt, $($rest:tt)*) => {
        run!(in 1, $registers<{ (SORT_BLOCK / $lanes) as usize }>, $shared, $groups, $at, $lanes, $($rest)*)
    };
    (subgroups($registers:ident; $shared:ty), $groups:expr, $at:expr, $lanes:tt, $($rest:tt)*) => {
        run!(in 32, $registers<{ (SORT_BLOCK / $lanes) as usize }>, $shared, $groups, $at, $lanes, $($rest)*)
    };
    (in $subgroup:tt, $registers:ty, $shared:ty, $groups:expr, $at:expr, $lanes:tt, $module:ident::$body:ident,
     $($access:ident $arg:ident),*) => {
        $groups.phases::<$registers, $shared>($at, $lanes, $subgroup, |lanes, group, shared| {
            $module::$body(lanes, group, shared, $(pass!($access $arg)),*);
        })
    };
}

stages!(kernels);
