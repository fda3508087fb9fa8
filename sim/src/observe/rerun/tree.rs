//! Views in containers, in the viewer's format of a layout.
//!
//! The typed views of the package know no bounds, axes or legends, so that a layout is logged
//! piece by piece into a store of its own, as the package does inside.

use ::rerun::external::re_log_types::BlueprintActivationCommand;
use ::rerun::external::re_sdk_types::blueprint::{archetypes as bp, components as bc};
use ::rerun::external::re_sdk_types::datatypes::Uuid;
use ::rerun::{
    AsComponents, EntityPath, EntityPathPart, RecordingStream, RecordingStreamBuilder, RecordingStreamResult,
};

use super::APPLICATION;

/// Path of a piece, and its share of the space of its parent.
pub(super) type Piece = (String, f32);

/// A property of a view: its name, and what it is.
pub(super) type Property<'a> = (&'a str, &'a dyn AsComponents);

/// How a container arranges its pieces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum ContainerKind {
    Horizontal,
    Vertical,
    Tabs,
}

/// Makes the viewer show a layout: the container that `root` makes last, at a timeline that a `live`
/// recording's viewer follows. The viewer keeps what it knows of the views of a layout for the next one of the
/// same `number`, and is confused if they are others.
pub(super) fn send(
    recording: &RecordingStream,
    number: u128,
    timeline: &str,
    live: bool,
    root: impl FnOnce(&mut Tree) -> RecordingStreamResult<()>,
) -> RecordingStreamResult<()> {
    let Some(info) = recording.store_info() else {
        return Ok(());
    };
    let store = format!("{}-layout", info.recording_id().as_str());
    let (stream, messages) =
        RecordingStreamBuilder::new(APPLICATION).recording_id(store).enabled(true).blueprint().memory()?;
    let Some(layout) = stream.store_info() else {
        return Ok(());
    };
    stream.set_time_sequence("blueprint", 0);
    let mut tree = Tree { stream: &stream, pieces: number << 64 };
    root(&mut tree)?;
    tree.log_panels(timeline, live)?;
    let activation =
        BlueprintActivationCommand { blueprint_id: layout.store_id, make_active: true, make_default: true };
    recording.send_blueprint(messages.take(), activation);
    Ok(())
}

/// Numbers the pieces of a layout, and logs them.
pub(super) struct Tree<'a> {
    stream: &'a RecordingStream,
    pieces: u128,
}

impl Tree<'_> {
    fn log_panels(&self, timeline: &str, live: bool) -> RecordingStreamResult<()> {
        self.stream.log(
            "viewport",
            &bp::ViewportBlueprint::new()
                .with_root_container(bc::RootContainer(Uuid { bytes: self.pieces.to_be_bytes() }))
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
            bp::TimePanelBlueprint::new().with_state(bc::PanelState::Collapsed).with_timeline(timeline);
        if live {
            time = time.with_play_state(bc::PlayState::Following);
        }
        self.stream.log("time_panel", &time)
    }

    pub fn view(
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

    /// A container that the viewer names after what it holds.
    pub fn container(&mut self, kind: ContainerKind, pieces: &[Piece]) -> RecordingStreamResult<String> {
        self.titled(kind, None, pieces)
    }

    /// A container with a name, which is that of its tab where it is in one.
    pub fn titled(
        &mut self,
        kind: ContainerKind,
        title: Option<&str>,
        pieces: &[Piece],
    ) -> RecordingStreamResult<String> {
        let path = self.next("container");
        let paths = pieces.iter().map(|(path, _)| path.as_str());
        let shares = || pieces.iter().map(|&(_, share)| share);
        let container = match kind {
            ContainerKind::Horizontal => {
                bp::ContainerBlueprint::new(bc::ContainerKind::Horizontal).with_col_shares(shares())
            }
            ContainerKind::Vertical => {
                bp::ContainerBlueprint::new(bc::ContainerKind::Vertical).with_row_shares(shares())
            }
            ContainerKind::Tabs => bp::ContainerBlueprint::new(bc::ContainerKind::Tabs),
        };
        let mut container = container.with_contents(paths);
        if let Some(title) = title {
            container = container.with_display_name(title);
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

/// All that is below a path.
pub(super) fn under(path: &str) -> String {
    format!("+ /{path}/**")
}

/// The path of something whose parts may have any name.
pub(super) fn path(parts: &[&str]) -> String {
    EntityPath::new(parts.iter().map(|part| EntityPathPart::new(*part)).collect()).to_string()
}
