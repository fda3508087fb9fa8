//! The layout that the recording of a run opens with.

use ::rerun::external::re_sdk_types::blueprint::{archetypes as bp, components as bc};
use ::rerun::external::re_sdk_types::datatypes::{Range1D, Range2D, TimeInt, TimeRange, TimeRangeBoundary};
use ::rerun::{RecordingStream, RecordingStreamResult};

use super::entities::{
    ENERGY, FORCE, FORCES, GRID_LABELS, MOMENT_ALONG, MOMENT_AT_ROOT, TIMELINE, TIP_HEIGHT,
};
use super::tree::{self, ContainerKind, Piece, Property, Tree, under};

/// What the spatial views show at least, W, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub x: [f64; 2],
    pub z: [f64; 2],
}

impl Bounds {
    /// All postures of a rod with this reach that was released below the horizontal or at it.
    pub fn hanging(reach: f64) -> Self {
        Self { x: [-reach, reach], z: [-reach, 0.35 * reach] }
    }

    /// What a view has to show for them.
    pub fn view(&self) -> bp::VisualBounds2D {
        bp::VisualBounds2D::new(bc::VisualBounds2D(Range2D {
            x_range: Range1D(self.x),
            y_range: Range1D([-self.z[1], -self.z[0]]), // the viewer's y points down
        }))
    }

    /// Grows to hold the point with some room to spare; whether that was needed.
    pub fn widen(&mut self, [x, z]: [f64; 2]) -> bool {
        let size = self.x[1] - self.x[0];
        let mut grown = false;
        for (value, [low, high]) in [(x, &mut self.x), (z, &mut self.z)] {
            if value.is_finite() && value < *low {
                *low = value - 0.1 * size;
                grown = true;
            } else if value.is_finite() && value > *high {
                *high = value + 0.1 * size;
                grown = true;
            }
        }
        grown
    }
}

/// What of a run the layout depends on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub bounds: Bounds,
    /// Length of the run, s; 0 if unknown.
    pub duration: f64,
    pub has_effects: bool,
    pub live: bool,
}

impl Layout {
    /// Makes the viewer show this layout.
    pub fn send(&self, recording: &RecordingStream) -> RecordingStreamResult<()> {
        tree::send(recording, 0, TIMELINE, self.live, |tree| self.root(tree))
    }

    /// The whole run, and room for the legend where it hides nothing.
    fn time_axis(&self) -> bp::TimeAxis {
        if self.duration <= 0.0 {
            return bp::TimeAxis::new().with_link(bc::LinkAxis::LinkToGlobal);
        }
        let at = |time: f64| TimeRangeBoundary::Absolute(TimeInt((1e9 * time) as i64));
        bp::TimeAxis::new()
            .with_view_range(bc::TimeRange(TimeRange { start: at(0.0), end: at(1.2 * self.duration) }))
    }

    fn root(&self, tree: &mut Tree) -> RecordingStreamResult<()> {
        let columns = [(self.rod(tree)?, 1.0), (self.plots(tree)?, 1.0)];
        tree.container(ContainerKind::Horizontal, &columns)?;
        Ok(())
    }

    fn rod(&self, tree: &mut Tree) -> RecordingStreamResult<String> {
        let bounds = self.bounds.view();
        let bounds: &[Property] = &[("VisualBounds2D", &bounds)];
        let without_forces = ["+ /world/**".to_owned(), format!("- /{FORCES}/**")];
        let mut tabs = vec![(tree.view("2D", "Rod, x right, z up (mm)", &without_forces, bounds)?, 1.0)];
        if self.has_effects {
            let all = ["+ /world/**".to_owned(), format!("- /{GRID_LABELS}/**")];
            tabs.push((tree.view("2D", "Forces on the rod (mN; length ~ square root)", &all, bounds)?, 1.0));
        }
        let rod = tree.container(ContainerKind::Tabs, &tabs)?;
        let title = "Bending moment (mN m) along the rod (mm from the clamp)";
        let hidden = bp::PlotLegend::new().with_visible(false);
        let hidden: &[Property] = &[("PlotLegend", &hidden)];
        let moment = tree.view("BarChart", title, &[under(MOMENT_ALONG)], hidden)?;
        tree.container(ContainerKind::Vertical, &[(rod, 2.6), (moment, 1.0)])
    }

    fn plots(&self, tree: &mut Tree) -> RecordingStreamResult<String> {
        let mut rows = vec![
            self.plot(tree, "Tip height z (mm)", TIP_HEIGHT, false)?,
            self.plot(tree, "Energy (mJ)", ENERGY, true)?,
            self.plot(tree, "Bending moment at the root (mN m)", MOMENT_AT_ROOT, false)?,
        ];
        if self.has_effects {
            rows.push(self.plot(tree, "Force of each effect, |f| summed over nodes (mN)", FORCE, true)?);
        }
        tree.container(ContainerKind::Vertical, &rows)
    }

    fn plot(&self, tree: &mut Tree, title: &str, path: &str, legend: bool) -> RecordingStreamResult<Piece> {
        let legend_at = bp::PlotLegend::new().with_corner(bc::Corner2D::RightTop).with_visible(legend);
        let time = self.time_axis();
        let properties: &[Property] = &[("PlotLegend", &legend_at), ("TimeAxis", &time)];
        let share = if legend { 1.3 } else { 1.1 };
        Ok((tree.view("TimeSeries", title, &[under(path)], properties)?, share))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_grow_once_for_a_rod_that_rises() {
        let mut bounds = Bounds::hanging(0.2);
        assert!(!bounds.widen([-0.1, -0.2]) && bounds == Bounds::hanging(0.2));
        assert!(bounds.widen([0.1, 0.15]));
        assert!(!bounds.widen([0.1, 0.16]) && bounds.z[1] < 0.2);
        assert!(bounds.widen([-0.21, 0.0]) && bounds.x[0] < -0.21);
        let before = bounds;
        assert!(!bounds.widen([f64::NAN, f64::INFINITY]) && bounds == before);
    }
}
