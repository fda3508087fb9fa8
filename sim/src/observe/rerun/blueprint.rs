//! The layout that a recording opens with.
//!
//! The typed views of the package know no bounds, axes or legends, so that the layout is logged
//! piece by piece into a store of its own, as the package does inside.

use ::rerun::external::re_log_types::BlueprintActivationCommand;
use ::rerun::external::re_sdk_types::blueprint::{archetypes as bp, components as bc};
use ::rerun::external::re_sdk_types::datatypes::{
    Range1D, Range2D, TimeInt, TimeRange, TimeRangeBoundary, Uuid,
};
use ::rerun::{AsComponents, RecordingStream, RecordingStreamBuilder, RecordingStreamResult};

use super::APPLICATION;
use super::drawing::{
    ENERGY, FORCE, FORCES, GRID_LABELS, MOMENT_ALONG, MOMENT_AT_ROOT, TIMELINE, TIP_HEIGHT,
};

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
        let Some(info) = recording.store_info() else {
            return Ok(());
        };
        let store = format!("{}-layout", info.recording_id().as_str());
        let (stream, messages) = RecordingStreamBuilder::new(APPLICATION)
            .recording_id(store)
            .enabled(true)
            .blueprint()
            .memory()?;
        let Some(layout) = stream.store_info() else {
            return Ok(());
        };
        stream.set_time_sequence("blueprint", 0);
        Tree::new(&stream).log(self)?;
        let activation = BlueprintActivationCommand {
            blueprint_id: layout.store_id,
            make_active: true,
            make_default: true,
        };
        recording.send_blueprint(messages.take(), activation);
        Ok(())
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

    fn bounds(&self) -> bp::VisualBounds2D {
        let Bounds { x, z } = self.bounds;
        bp::VisualBounds2D::new(bc::VisualBounds2D(Range2D {
            x_range: Range1D(x),
            y_range: Range1D([-z[1], -z[0]]), // the viewer's y points down
        }))
    }
}

/// Numbers the pieces of a layout, and logs them.
struct Tree<'a> {
    stream: &'a RecordingStream,
    pieces: u128,
}

/// Path of a piece, and its share of the space of its parent.
type Piece = (String, f32);

/// A property of a view: its name, and what it is.
type Property<'a> = (&'a str, &'a dyn AsComponents);

impl<'a> Tree<'a> {
    fn new(stream: &'a RecordingStream) -> Self {
        Self { stream, pieces: 0 }
    }

    fn log(mut self, layout: &Layout) -> RecordingStreamResult<()> {
        let root = self.root(layout)?;
        self.stream.log(
            "viewport",
            &bp::ViewportBlueprint::new()
                .with_root_container(bc::RootContainer(root))
                .with_auto_layout(false)
                .with_auto_views(false),
        )?;
        for (panel, state) in
            [("blueprint_panel", bc::PanelState::Collapsed), ("selection_panel", bc::PanelState::Collapsed)]
        {
            let panel_state = bp::PanelBlueprint::new().with_state(state);
            self.stream.log(panel, &panel_state)?;
        }
        let mut time =
            bp::TimePanelBlueprint::new().with_state(bc::PanelState::Collapsed).with_timeline(TIMELINE);
        if layout.live {
            time = time.with_play_state(bc::PlayState::Following);
        }
        self.stream.log("time_panel", &time)
    }

    fn root(&mut self, layout: &Layout) -> RecordingStreamResult<Uuid> {
        let left = self.rod(layout)?;
        let right = self.plots(layout)?;
        let columns = [(left, 1.0), (right, 1.0)];
        self.container(bc::ContainerKind::Horizontal, &columns)?;
        Ok(id(self.pieces))
    }

    fn rod(&mut self, layout: &Layout) -> RecordingStreamResult<String> {
        let bounds = layout.bounds();
        let bounds: &[Property] = &[("VisualBounds2D", &bounds)];
        let without_forces = ["+ /world/**".to_owned(), format!("- /{FORCES}/**")];
        let mut tabs = vec![(self.view("2D", "Rod, x right, z up (mm)", &without_forces, bounds)?, 1.0)];
        if layout.has_effects {
            let all = ["+ /world/**".to_owned(), format!("- /{GRID_LABELS}/**")];
            tabs.push((self.view("2D", "Forces on the rod (mN; length ~ square root)", &all, bounds)?, 1.0));
        }
        let rod = self.container(bc::ContainerKind::Tabs, &tabs)?;
        let title = "Bending moment (mN m) along the rod (mm from the clamp)";
        let hidden = bp::PlotLegend::new().with_visible(false);
        let hidden: &[Property] = &[("PlotLegend", &hidden)];
        let moment = self.view("BarChart", title, &[under(MOMENT_ALONG)], hidden)?;
        self.container(bc::ContainerKind::Vertical, &[(rod, 2.6), (moment, 1.0)])
    }

    fn plots(&mut self, layout: &Layout) -> RecordingStreamResult<String> {
        let mut rows = vec![
            self.plot(layout, "Tip height z (mm)", TIP_HEIGHT, false)?,
            self.plot(layout, "Energy (mJ)", ENERGY, true)?,
            self.plot(layout, "Bending moment at the root (mN m)", MOMENT_AT_ROOT, false)?,
        ];
        if layout.has_effects {
            rows.push(self.plot(layout, "Force of each effect, |f| summed over nodes (mN)", FORCE, true)?);
        }
        self.container(bc::ContainerKind::Vertical, &rows)
    }

    fn plot(
        &mut self,
        layout: &Layout,
        title: &str,
        path: &str,
        legend: bool,
    ) -> RecordingStreamResult<Piece> {
        let legend_at = bp::PlotLegend::new().with_corner(bc::Corner2D::RightTop).with_visible(legend);
        let time = layout.time_axis();
        let properties: &[Property] = &[("PlotLegend", &legend_at), ("TimeAxis", &time)];
        let share = if legend { 1.3 } else { 1.1 };
        Ok((self.view("TimeSeries", title, &[under(path)], properties)?, share))
    }

    fn view(
        &mut self,
        class: &str,
        title: &str,
        contents: &[String],
        properties: &[Property],
    ) -> RecordingStreamResult<String> {
        let path = self.next("view");
        let view = bp::ViewBlueprint::new(class).with_display_name(title).with_space_origin("/");
        self.stream.log(path.as_str(), &view)?;
        let queries = contents.iter().map(String::as_str);
        self.stream.log(format!("{path}/ViewContents"), &bp::ViewContents::new(queries))?;
        for (name, property) in properties {
            self.stream.log(format!("{path}/{name}"), *property)?;
        }
        Ok(path)
    }

    fn container(&mut self, kind: bc::ContainerKind, pieces: &[Piece]) -> RecordingStreamResult<String> {
        let path = self.next("container");
        let paths = pieces.iter().map(|(path, _)| path.as_str());
        let shares = || pieces.iter().map(|&(_, share)| share);
        let mut container = bp::ContainerBlueprint::new(kind).with_contents(paths);
        match kind {
            bc::ContainerKind::Horizontal => container = container.with_col_shares(shares()),
            bc::ContainerKind::Vertical => container = container.with_row_shares(shares()),
            bc::ContainerKind::Tabs | bc::ContainerKind::Grid => {}
        }
        self.stream.log(path.as_str(), &container)?;
        Ok(path)
    }

    fn next(&mut self, kind: &str) -> String {
        self.pieces += 1;
        let hex = format!("{:032x}", self.pieces);
        let (a, b, c, d, e) = (&hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..]);
        format!("{kind}/{a}-{b}-{c}-{d}-{e}")
    }
}

fn id(number: u128) -> Uuid {
    Uuid { bytes: number.to_be_bytes() }
}

fn under(path: &str) -> String {
    format!("+ /{path}/**")
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
