//! The list of every kernel, from which the shader crate makes its entry points and the CPU backend its drivers.

/// Calls the macro `$with` with the list of stages.
///
/// A line reads `shape Name = entry_point [lanes] (parameters) = body`, where
///
/// * the shape is `each` (one invocation an element), `masked` (the same, with the mask of what the kernel is to [know](crate::trace::known) as its first
///   parameter), `batch (registers)` (the same in phases, without barriers), `group (registers; shared)` (a workgroup in phases),
///   `subgroups (registers; shared)` (a block of [`SORT_BLOCK`](crate::sort::SORT_BLOCK) items, shared out among lanes in subgroups
///   with ballots), `lanes (registers; shared)` (the same without subgroups), `columns (shared)` (like `each`, with the lane and shared memory
///   in which each lane has its own column) or `gather (container)` (like `each`, with a container of candidates as its first
///   parameter);
/// * a parameter `b name: Access T` is the buffer of binding `b`: `One T` a single record and `In T` a slice, both read;
///   `Out T` a slice that the stage writes and does not read; `InOut T` a slice that it changes in place.
///
/// A body may be followed by its generic arguments. The order of the bindings is the order of the body's parameters. This list is the only place that says which buffers
/// a stage has.
#[macro_export]
macro_rules! stages {
    ($with:ident) => {
        $with! {
            subgroups(BlockRegisters; CountShared) RadixCount = radix_count [256] (
                0 pass: One RadixPass, 1 keys: In u32, 2 histogram: Out u32
            ) = sort::radix_count;
            subgroups(BlockRegisters; NarrowCountShared) RadixCountNarrow = radix_count_narrow [128] (
                0 pass: One RadixPass, 1 keys: In u32, 2 histogram: Out u32
            ) = sort::radix_count;
            lanes(BlockRegisters; NarrowCountShared) RadixCountPlain = radix_count_plain [16] (
                0 pass: One RadixPass, 1 keys: In u32, 2 histogram: Out u32
            ) = sort::radix_count;
            group(ScanRegisters; ScanShared) ScanRows = scan_rows [256] (
                0 params: One ScanParams, 1 input: In u32, 2 sums: Out u32, 3 totals: Out u32
            ) = sort::scan_rows;
            subgroups(BlockRegisters; ScatterShared) RadixScatter = radix_scatter [512] (
                0 pass: One RadixPass, 1 keys: In u32, 2 values: In u32, 3 offsets: In u32, 4 digit_totals: In u32,
                5 keys_out: Out u32, 6 values_out: Out u32
            ) = sort::radix_scatter;
            subgroups(BlockRegisters; ScatterShared) RadixScatterNarrow = radix_scatter_narrow [128] (
                0 pass: One RadixPass, 1 keys: In u32, 2 values: In u32, 3 offsets: In u32, 4 digit_totals: In u32,
                5 keys_out: Out u32, 6 values_out: Out u32
            ) = sort::radix_scatter;
            lanes(BlockRegisters; ScatterShared) RadixScatterPlain = radix_scatter_plain [16] (
                0 pass: One RadixPass, 1 keys: In u32, 2 values: In u32, 3 offsets: In u32, 4 digit_totals: In u32,
                5 keys_out: Out u32, 6 values_out: Out u32
            ) = sort::radix_scatter;

            lanes(GridRegisters; LargestShared) HashPhotons = hash_photons [256] (
                0 grid: One Grid, 1 photons: In Photon, 2 keys: Out u32, 3 powers: Out u32
            ) = grid::hash_photons;
            lanes(GridRegisters; BeginsShared) CellBegins = cell_begins [256] (
                0 grid: One Grid, 1 keys: In u32, 2 powers: In u32, 3 begins: Out u32, 4 power: Out u32
            ) = grid::cell_begins;
            batch(Moved) ReorderPhotons = reorder_photons [256] (
                0 grid: One Grid, 1 order: In u32, 2 photons: In Photon, 3 power: In u32, 4 sites: Out Site,
                5 arrivals: Out Arrival
            ) = grid::reorder_photons;
            each HashQueries = hash_queries [256] (
                0 params: One GatherParams, 1 grid: One Grid, 2 queries: In Query, 3 keys: Out u32
            ) = grid::hash_queries;
            each MarkCells = mark_cells [256] (
                0 grid: One Grid, 1 begins: In u32, 2 seen: InOut u32
            ) = grid::mark_cells;
            each SeePhotons = see_photons [256] (
                0 grid: One Grid, 1 seen: In u32, 2 photons: In Photon, 3 near: Out u32
            ) = grid::see_photons;
            each KeepPhotons = keep_photons [256] (
                0 grid: One Grid, 1 photons: In Photon, 2 near: In u32, 3 offsets: In u32, 4 block_offsets: In u32,
                5 kept: Out Photon
            ) = grid::keep_photons;

            columns(Columns) IrradianceHistogram = irradiance_histogram [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance_by_counting[true, _];
            columns(Columns) IrradianceHistogramHashed = irradiance_histogram_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance_by_counting[false, _];
            gather(Heap<17>) IrradianceHeap17 = irradiance_heap_17 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(Heap<65>) IrradianceHeap65 = irradiance_heap_65 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(Heap<257>) IrradianceHeap257 = irradiance_heap_257 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(Heap<1025>) IrradianceHeap1025 = irradiance_heap_1025 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(SortedList<17>) IrradianceList17 = irradiance_list_17 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(SortedList<65>) IrradianceList65 = irradiance_list_65 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(SortedList<257>) IrradianceList257 = irradiance_list_257 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            gather(SortedList<1025>) IrradianceList1025 = irradiance_list_1025 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_irradiance;
            each IrradianceDensity = irradiance_density [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_density[true, _];
            each IrradianceDensityHashed = irradiance_density_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_density[false, _];
            each PowerWithin = power_within [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 sums: InOut PowerSum
            ) = gather::gather_power[true, _];
            each PowerWithinHashed = power_within_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 arrivals: In Arrival, 7 begins: In u32, 8 sums: InOut PowerSum
            ) = gather::gather_power[false, _];
            each FaceArrivals = face_arrivals [256] (
                0 grid: One Grid, 1 primitives: In Primitive, 2 sites: In Site, 3 arrivals: InOut Arrival
            ) = gather::face_arrivals;
            columns(Columns) ReachHistogram = reach_histogram [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 reaches: Out Reach
            ) = gather::gather_reach[true, _, _];
            columns(Columns) ReachHistogramHashed = reach_histogram_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 reaches: Out Reach
            ) = gather::gather_reach[false, _, _];
            each LikelyReach = likely_reach [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 queries: In Query, 3 query_order: In u32, 4 begins: In u32,
                5 reaches: Out Reach
            ) = gather::likely_reach;
            each LikelyReachHashed = likely_reach_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 queries: In Query, 3 query_order: In u32, 4 sites: In Site,
                5 begins: In u32, 6 reaches: Out Reach
            ) = gather::likely_reach_hashed;
            each LikelyReachCompact = likely_reach_compact [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 queries: In Query, 3 query_order: In u32, 4 records: In Compact,
                5 begins: In u32, 6 reaches: Out Reach
            ) = gather::likely_reach_hashed;
            each SnapPhotons = snap_photons [256] (
                0 grid: One Grid, 1 photons: InOut Photon
            ) = gather::snap_photons;
            batch(Moved) ReorderCompact = reorder_compact [256] (
                0 grid: One Grid, 1 order: In u32, 2 photons: In Photon, 3 records: Out Compact
            ) = gather::reorder_compact;
            columns(Columns) ReachCompact = reach_compact [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 records: In Compact, 6 begins: In u32, 7 reaches: Out Reach
            ) = gather::gather_reach[true, _, _];
            columns(Columns) ReachCompactHashed = reach_compact_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 records: In Compact, 6 begins: In u32, 7 reaches: Out Reach
            ) = gather::gather_reach[false, _, _];
            each IrradianceCompact = irradiance_compact [64] (
                0 params: One EstimateParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 reaches: In Reach, 6 records: In Compact, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_compact[true, _];
            each IrradianceCompactHashed = irradiance_compact_hashed [64] (
                0 params: One EstimateParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 reaches: In Reach, 6 records: In Compact, 7 begins: In u32, 8 power: In u32, 9 irradiance: Out Irradiance
            ) = gather::gather_compact[false, _];
            each IrradianceFiltered = irradiance_filtered [64] (
                0 params: One EstimateParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 reaches: In Reach, 6 vertices: In Vertex, 7 primitives: In Primitive, 8 sites: In Site,
                9 arrivals: In Arrival, 10 begins: In u32, 11 power: In u32, 12 irradiance: Out Irradiance
            ) = gather::gather_filtered[true, _];
            each IrradianceFilteredHashed = irradiance_filtered_hashed [64] (
                0 params: One EstimateParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 reaches: In Reach, 6 vertices: In Vertex, 7 primitives: In Primitive, 8 sites: In Site,
                9 arrivals: In Arrival, 10 begins: In u32, 11 power: In u32, 12 irradiance: Out Irradiance
            ) = gather::gather_filtered[false, _];
            columns(WideColumns) NeighboursHistogram = neighbours_histogram [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 unordered: Out Neighbour, 8 counts: Out u32, 9 windows: Out u32
            ) = gather::gather_neighbours_by_counting[true, _, _, _];
            columns(WideColumns) NeighboursHistogramHashed = neighbours_histogram_hashed [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 unordered: Out Neighbour, 8 counts: Out u32, 9 windows: Out u32
            ) = gather::gather_neighbours_by_counting[false, _, _, _];
            each OrderNeighbours = order_neighbours [64] (
                0 params: One GatherParams, 1 counts: In u32, 2 windows: In u32, 3 unordered: In Neighbour,
                4 neighbours: Out Neighbour
            ) = gather::order_neighbours;
            gather(Heap<17>) NeighboursHeap17 = neighbours_heap_17 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(Heap<65>) NeighboursHeap65 = neighbours_heap_65 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(Heap<257>) NeighboursHeap257 = neighbours_heap_257 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(Heap<1025>) NeighboursHeap1025 = neighbours_heap_1025 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(SortedList<17>) NeighboursList17 = neighbours_list_17 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(SortedList<65>) NeighboursList65 = neighbours_list_65 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(SortedList<257>) NeighboursList257 = neighbours_list_257 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;
            gather(SortedList<1025>) NeighboursList1025 = neighbours_list_1025 [64] (
                0 params: One GatherParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 query_order: In u32,
                5 sites: In Site, 6 begins: In u32, 7 neighbours: Out Neighbour, 8 counts: Out u32
            ) = gather::gather_neighbours;

            each EstimateOfNeighbours = estimate_of_neighbours [64] (
                0 params: One SearchParams, 1 photons: In Photon, 2 power: In u32, 3 neighbours: In Neighbour, 4 counts: In u32,
                5 irradiance: Out Irradiance
            ) = rivals::estimate_of_neighbours;
            group([f32; 3]; BruteTile) BruteDistance = brute_distance [256] (
                0 params: One BruteParams, 1 queries: In Query, 2 photons: In Photon, 3 distances: Out f32
            ) = rivals::brute_distance;
            each BruteInsertionSort = brute_insertion_sort [64] (
                0 params: One BruteParams, 1 distances: InOut f32, 2 indices: InOut u32, 3 sorted: Out u32
            ) = rivals::brute_insertion_sort;
            each BruteCombSort = brute_comb_sort [64] (
                0 params: One BruteParams, 1 distances: InOut f32, 2 indices: InOut u32, 3 sorted: Out u32
            ) = rivals::brute_comb_sort;
            each BruteCopy = brute_copy [256] (
                0 params: One BruteParams, 1 queries: In Query, 2 distances: In f32, 3 indices: In u32, 4 sorted: In u32,
                5 neighbours: Out Neighbour, 6 counts: Out u32
            ) = rivals::brute_copy;
            group(CellsRegisters<17>; [u32; cells_words(17)]) CellsNeighbours17 = cells_neighbours_17 [32] (
                0 params: One SearchParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 sites: In Site,
                5 begins: In u32, 6 neighbours: Out Neighbour, 7 counts: Out u32
            ) = rivals::cells_neighbours;
            group(CellsRegisters<65>; [u32; cells_words(65)]) CellsNeighbours65 = cells_neighbours_65 [32] (
                0 params: One SearchParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 sites: In Site,
                5 begins: In u32, 6 neighbours: Out Neighbour, 7 counts: Out u32
            ) = rivals::cells_neighbours;
            group(CellsRegisters<257>; [u32; cells_words(257)]) CellsNeighbours257 = cells_neighbours_257 [32] (
                0 params: One SearchParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 sites: In Site,
                5 begins: In u32, 6 neighbours: Out Neighbour, 7 counts: Out u32
            ) = rivals::cells_neighbours;
            group(CellsRegisters<1025>; [u32; cells_words(1025)]) CellsNeighbours1025 = cells_neighbours_1025 [32] (
                0 params: One SearchParams, 1 grid: One Grid, 2 rows: In Row, 3 queries: In Query, 4 sites: In Site,
                5 begins: In u32, 6 neighbours: Out Neighbour, 7 counts: Out u32
            ) = rivals::cells_neighbours;
            gather(Heap<17>) JensenNeighbours17 = jensen_neighbours_17 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 nodes: In Site, 3 neighbours: Out Neighbour,
                4 counts: Out u32
            ) = rivals::jensen_neighbours;
            gather(Heap<65>) JensenNeighbours65 = jensen_neighbours_65 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 nodes: In Site, 3 neighbours: Out Neighbour,
                4 counts: Out u32
            ) = rivals::jensen_neighbours;
            gather(Heap<257>) JensenNeighbours257 = jensen_neighbours_257 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 nodes: In Site, 3 neighbours: Out Neighbour,
                4 counts: Out u32
            ) = rivals::jensen_neighbours;
            gather(Heap<1025>) JensenNeighbours1025 = jensen_neighbours_1025 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 nodes: In Site, 3 neighbours: Out Neighbour,
                4 counts: Out u32
            ) = rivals::jensen_neighbours;
            each KdKeys = kd_keys [256] (
                0 level: One KdLevel, 1 photons: In Photon, 2 x: Out u32, 3 y: Out u32, 4 z: Out u32
            ) = rivals::kd_keys;
            each KdBegin = kd_begin [256] (
                0 level: One KdLevel, 1 x: In u32, 2 y: In u32, 3 z: In u32, 4 orders: Out u32, 5 owners: Out u32
            ) = rivals::kd_begin;
            each KdSplitLarge = kd_split_large [64] (
                0 level: One KdLevel, 1 photons: In Photon, 2 orders: In u32, 3 nodes: In KdLarge, 4 splits: Out KdSplit,
                5 children: Out KdLarge, 6 is_large: Out u32, 7 tree: Out Site
            ) = rivals::kd_split_large;
            each KdHandOut = kd_hand_out [64] (
                0 level: One KdLevel, 1 children: In KdLarge, 2 is_large: In u32, 3 sums: In u32, 4 offsets: In u32,
                5 next: Out KdLarge, 6 roots: Out KdSmall
            ) = rivals::kd_hand_out;
            each KdClassify = kd_classify [256] (
                0 level: One KdLevel, 1 owners: In u32, 2 splits: In KdSplit, 3 orders: In u32, 4 is_large: In u32,
                5 sums: In u32, 6 offsets: In u32, 7 sides: Out u32, 8 next_owners: Out u32
            ) = rivals::kd_classify;
            each KdListSides = kd_list_sides [256] (
                0 level: One KdLevel, 1 orders: In u32, 2 sides: In u32, 3 flags: Out u32
            ) = rivals::kd_list_sides;
            each KdMove = kd_move [256] (
                0 level: One KdLevel, 1 owners: In u32, 2 splits: In KdSplit, 3 orders: In u32, 4 flags: In u32,
                5 sums: In u32, 6 offsets: In u32, 7 next_orders: Out u32
            ) = rivals::kd_move;
            each KdMembers = kd_members [256] (
                0 level: One KdLevel, 1 photons: In Photon, 2 orders: In u32, 3 members: Out Site
            ) = rivals::kd_members;
            each KdMasks = kd_masks [64] (
                0 level: One KdLevel, 1 owners: In u32, 2 roots: In KdSmall, 3 members: In Site, 4 masks: Out u32
            ) = rivals::kd_masks;
            each KdSplitSmall = kd_split_small [64] (
                0 level: One KdLevel, 1 nodes: In KdSmall, 2 members: In Site, 3 masks: In u32, 4 lefts: Out u32,
                5 is_split: Out u32, 6 tree: Out Site
            ) = rivals::kd_split_small;
            each KdCompact = kd_compact [256] (
                0 level: One KdLevel, 1 nodes: In KdSmall, 2 lefts: In u32, 3 sums: In u32, 4 offsets: In u32,
                5 next: Out KdSmall
            ) = rivals::kd_compact;
            columns(Columns) KdRadii = kd_radii [64] (
                0 params: One KdRadius, 1 queries: In Query, 2 tree: In Site, 3 radii2: Out f32
            ) = rivals::kd_radius;
            gather(Heap<17>) KdNearest17 = kd_nearest_17 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 tree: In Site, 3 neighbours: Out Neighbour, 4 counts: Out u32
            ) = rivals::kd_nearest;
            gather(Heap<65>) KdNearest65 = kd_nearest_65 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 tree: In Site, 3 neighbours: Out Neighbour, 4 counts: Out u32
            ) = rivals::kd_nearest;
            gather(Heap<257>) KdNearest257 = kd_nearest_257 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 tree: In Site, 3 neighbours: Out Neighbour, 4 counts: Out u32
            ) = rivals::kd_nearest;
            gather(Heap<1025>) KdNearest1025 = kd_nearest_1025 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 tree: In Site, 3 neighbours: Out Neighbour, 4 counts: Out u32
            ) = rivals::kd_nearest;
            gather(Heap<17>) KdRange17 = kd_range_17 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 radii2: In f32, 3 tree: In Site, 4 neighbours: Out Neighbour,
                5 counts: Out u32
            ) = rivals::kd_range;
            gather(Heap<65>) KdRange65 = kd_range_65 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 radii2: In f32, 3 tree: In Site, 4 neighbours: Out Neighbour,
                5 counts: Out u32
            ) = rivals::kd_range;
            gather(Heap<257>) KdRange257 = kd_range_257 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 radii2: In f32, 3 tree: In Site, 4 neighbours: Out Neighbour,
                5 counts: Out u32
            ) = rivals::kd_range;
            gather(Heap<1025>) KdRange1025 = kd_range_1025 [64] (
                0 params: One SearchParams, 1 queries: In Query, 2 radii2: In f32, 3 tree: In Site, 4 neighbours: Out Neighbour,
                5 counts: Out u32
            ) = rivals::kd_range;

            masked CountPhotons = count_photons [64] (
                0 pass: One PhotonPass, 1 info: One SceneInfo, 2 nodes: In BvhNode, 3 primitives: In Primitive,
                4 materials: In Material, 5 lights: In Light, 6 targets: In Target, 7 corners: In Corners,
                8 textures: In Texture, 9 texels: In Texel, 10 counts: Out u32, 11 fates: Out u32, 12 segments: Out u32,
                13 tallies: Out Tally
            ) = trace::count_photons;
            masked StorePhotons = store_photons [64] (
                0 pass: One PhotonPass, 1 info: One SceneInfo, 2 nodes: In BvhNode, 3 primitives: In Primitive,
                4 materials: In Material, 5 lights: In Light, 6 targets: In Target, 7 corners: In Corners,
                8 textures: In Texture, 9 texels: In Texel, 10 counts: In u32, 11 offsets: In u32, 12 block_offsets: In u32,
                13 photons: Out Photon
            ) = trace::store_photons;
            each SumLedger = sum_ledger [64] (
                0 pass: One LedgerPass, 1 blocks: In LedgerBlock, 2 tallies: In Tally, 3 sums: Out LedgerSum
            ) = trace::sum_ledger;
            masked TraceCamera = trace_camera [64] (
                0 tile: One CameraTile, 1 camera: One Camera, 2 info: One SceneInfo, 3 nodes: In BvhNode,
                4 primitives: In Primitive, 5 materials: In Material, 6 lights: In Light, 7 corners: In Corners,
                8 textures: In Texture, 9 texels: In Texel, 10 queries: Out Query, 11 vertices: Out Vertex
            ) = trace::trace_camera;
            masked ShadeDirect = shade_direct [64] (
                0 tile: One CameraTile, 1 info: One SceneInfo, 2 nodes: In BvhNode, 3 primitives: In Primitive,
                4 materials: In Material, 5 lights: In Light, 6 corners: In Corners, 7 textures: In Texture, 8 texels: In Texel,
                9 queries: In Query, 10 vertices: In Vertex, 11 direct: Out Irradiance
            ) = trace::shade_direct;
            masked TracePaths = trace_paths [64] (
                0 tile: One CameraTile, 1 camera: One Camera, 2 info: One SceneInfo, 3 nodes: In BvhNode,
                4 primitives: In Primitive, 5 materials: In Material, 6 lights: In Light, 7 corners: In Corners,
                8 textures: In Texture, 9 texels: In Texel, 10 vertices: Out Vertex
            ) = trace::trace_paths;
            masked TraceGather = trace_gather [64] (
                0 tile: One GatherTile, 1 info: One SceneInfo, 2 nodes: In BvhNode, 3 primitives: In Primitive,
                4 materials: In Material, 5 lights: In Light, 6 corners: In Corners, 7 textures: In Texture, 8 texels: In Texel,
                9 queries: In Query, 10 vertices: In Vertex, 11 gather_queries: Out Query, 12 gather_vertices: Out Vertex
            ) = trace::trace_gather;
            each SumGather = sum_gather [64] (
                0 tile: One GatherTile, 1 gather_vertices: In Vertex, 2 estimates: In Irradiance, 3 irradiance: Out Irradiance
            ) = trace::sum_gather;
            each SpareQueries = spare_queries [64] (
                0 tile: One LatticeTile, 1 camera: One Camera, 2 queries: In Query, 3 vertices: In Vertex,
                4 key_queries: In Query, 5 key_vertices: In Vertex, 6 spared: Out Query
            ) = trace::spare_queries;
            each LendIrradiance = lend_irradiance [64] (
                0 tile: One LatticeTile, 1 camera: One Camera, 2 queries: In Query, 3 vertices: In Vertex,
                4 key_queries: In Query, 5 key_vertices: In Vertex, 6 key_irradiance: In Irradiance, 7 spared: In Query,
                8 own: In Irradiance, 9 irradiance: Out Irradiance
            ) = trace::lend_irradiance;
            each DevelopFilm = develop_film [64] (
                0 tile: One FilmTile, 1 vertices: In Vertex, 2 direct: In Irradiance, 3 global: In Irradiance,
                4 caustic: In Irradiance, 5 film: Out Pixel
            ) = trace::develop_film;
            each DevelopLayers = develop_layers [64] (
                0 tile: One FilmTile, 1 vertices: In Vertex, 2 direct: In Irradiance, 3 global: In Irradiance,
                4 caustic: In Irradiance, 5 global_reach: In Reach, 6 caustic_reach: In Reach,
                7 global_half: In Irradiance, 8 caustic_half: In Irradiance, 9 layers: Out LayerPixel
            ) = trace::develop_layers;

            each ProbeArithmetic = probe_arithmetic [64] (
                0 params: One ArithmeticParams, 1 results: Out Arithmetic
            ) = probe::arithmetic;
            each CopyQuads = copy_quads [256] (
                0 input: In Site, 1 output: Out Site
            ) = probe::copy_quads;
            each LayoutMap = layout_map [64] (
                0 photons: In Photon, 1 queries: In Query, 2 neighbours: In Neighbour, 3 irradiance: In Irradiance,
                4 sums: In PowerSum, 5 words: Out u32
            ) = probe::layout_map;
            each LayoutGrid = layout_grid [64] (
                0 grid: In Grid, 1 rows: In Row, 2 gather: In GatherParams, 3 estimate: In EstimateParams,
                4 reaches: In Reach, 5 words: Out u32
            ) = probe::layout_grid;
            each LayoutRivals = layout_rivals [64] (
                0 search: In SearchParams, 1 brute: In BruteParams, 2 words: Out u32
            ) = probe::layout_rivals;
            each LayoutKd = layout_kd [64] (
                0 level: In KdLevel, 1 large: In KdLarge, 2 split: In KdSplit, 3 small: In KdSmall, 4 radius: In KdRadius,
                5 words: Out u32
            ) = probe::layout_kd;
            each LayoutSort = layout_sort [64] (
                0 radix: In RadixPass, 1 scan: In ScanParams, 2 pass: In PhotonPass, 3 targets: In Target, 4 words: Out u32
            ) = probe::layout_sort;
            each LayoutScene = layout_scene [64] (
                0 info: In SceneInfo, 1 nodes: In BvhNode, 2 primitives: In Primitive, 3 materials: In Material,
                4 lights: In Light, 5 words: Out u32
            ) = probe::layout_scene;
            each LayoutSurface = layout_surface [64] (
                0 corners: In Corners, 1 textures: In Texture, 2 texels: In Texel, 3 words: Out u32
            ) = probe::layout_surface;
            each LayoutLedger = layout_ledger [64] (
                0 tallies: In Tally, 1 pass: In LedgerPass, 2 blocks: In LedgerBlock, 3 sums: In LedgerSum, 4 words: Out u32
            ) = probe::layout_ledger;
            each LayoutFilm = layout_film [64] (
                0 camera: In Camera, 1 tile: In CameraTile, 2 vertices: In Vertex, 3 film_tile: In FilmTile, 4 film: In Pixel,
                5 gather: In GatherTile, 6 layers: In LayerPixel, 7 lattice: In LatticeTile, 8 words: Out u32
            ) = probe::layout_film;
        }
    };
}
