//! Places in the recording: its timeline, and the paths of what is drawn and plotted.

pub(super) const TIMELINE: &str = "sim_time";
pub(super) const TIP_HEIGHT: &str = "plots/tip_height_mm";
pub(super) const ENERGY: &str = "plots/energy_mJ";
pub(super) const MOMENT_AT_ROOT: &str = "plots/moment_at_root_mNm";
pub(super) const MOMENT_ALONG: &str = "plots/moment_along_rod_mNm";
pub(super) const FORCE: &str = "plots/effect_force_mN";
pub(super) const FORCES: &str = "world/fam/sim/forces";
pub(super) const GRID_LABELS: &str = "world/grid/labels";
pub(super) const ROD: &str = "world/fam/sim/rod";
pub(super) const NODES: &str = "world/fam/sim/nodes";
pub(super) const BODY: &str = "world/fam/sim/end_fitting";
pub(super) const PAYLOAD: &str = "world/fam/sim/payload";
pub(super) const TIP: &str = "world/fam/sim/tip";
pub(super) const TRAIL: &str = "world/fam/sim/tip_trail";
