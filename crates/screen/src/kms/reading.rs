//! Reading a card's resources from the kernel.
//!
//! Owns the calls that read connectors, CRTCs and planes, and turns them into the plain data of `card.rs`. Property
//! names are cached in `properties.rs`.
//!
//! Start at [`read_survey`].

use super::card::{Connector, ConnectorStatus, Crtc, Id, Plane, PlaneFormat, Properties, Survey};
use super::in_formats::formats_with;
use super::properties::PropertyCache;
use crate::paint::Format;
use drm::control::{Device as Control, ResourceHandle, ResourceHandles, connector, crtc, from_u32, plane};
use rustix::io::Errno;
use std::io;

/// Probes the connectors of `card` and reads everything.
///
/// * `modifiers` — whether the kernel takes modifiers with a framebuffer.
pub(super) fn read_survey(card: &impl Control, modifiers: bool, cache: &mut PropertyCache) -> io::Result<Survey> {
    let resources = card.resource_handles()?;
    let driver = card.get_driver().map(|driver| driver.name().to_string_lossy().into_owned()).unwrap_or_default();
    let mut survey = Survey { driver, ..Survey::default() };
    for &id in resources.connectors() {
        survey.connectors.push(read_connector(card, Id(id.into()), &resources, cache)?);
    }
    for (index, &id) in resources.crtcs().iter().enumerate() {
        let mode = uninterrupted(|| card.get_crtc(id))?.mode();
        let properties = read_properties(card, id, cache)?;
        survey.crtcs.push(Crtc { id: Id(id.into()), index: index as u32, mode, properties });
    }
    for id in card.plane_handles()? {
        survey.planes.push(read_plane(card, id, &resources, modifiers, cache)?);
    }
    Ok(survey)
}

/// Probes the connector `id`: asks its display. The display may answer slowly.
pub(super) fn read_connector(
    card: &impl Control,
    id: Id,
    resources: &ResourceHandles,
    cache: &mut PropertyCache,
) -> io::Result<Connector> {
    let connector: connector::Handle = handle(id)?;
    let info = uninterrupted(|| card.get_connector(connector, true))?;
    let mut crtcs = 0;
    for &encoder in info.encoders() {
        let able = uninterrupted(|| card.get_encoder(encoder))?.possible_crtcs();
        crtcs |= mask(resources, &resources.filter_crtcs(able));
    }
    Ok(Connector {
        id,
        name: info.to_string(),
        plug: match info.state() {
            connector::State::Connected => ConnectorStatus::In,
            connector::State::Unknown => ConnectorStatus::Unknown,
            connector::State::Disconnected => ConnectorStatus::Out,
        },
        modes: info.modes().to_vec(),
        crtcs,
        properties: read_properties(card, connector, cache)?,
    })
}

fn read_plane(
    card: &impl Control,
    id: plane::Handle,
    resources: &ResourceHandles,
    modifiers: bool,
    cache: &mut PropertyCache,
) -> io::Result<Plane> {
    let info = uninterrupted(|| card.get_plane(id))?;
    let properties = read_properties(card, id, cache)?;
    let blob = properties.value("IN_FORMATS");
    let explicit = modifiers && blob != 0;
    let fourccs = if explicit { formats_with(&card.get_property_blob(blob)?, 0) } else { info.formats().to_vec() };
    let formats = Format::ALL.into_iter().filter(|format| fourccs.contains(&format.fourcc()));
    Ok(Plane {
        id: Id(id.into()),
        crtcs: mask(resources, &resources.filter_crtcs(info.possible_crtcs())),
        formats: formats.map(|format| PlaneFormat { format, explicit }).collect(),
        properties,
    })
}

/// The properties of `object`, with their present values.
pub(super) fn read_properties<T: ResourceHandle>(
    card: &impl Control,
    object: T,
    cache: &mut PropertyCache,
) -> io::Result<Properties> {
    let values = uninterrupted(|| card.get_properties(object))?;
    cache.read(card, &values)
}

/// The card's CRTCs that are in `able`, as bits by index.
fn mask(resources: &ResourceHandles, able: &[crtc::Handle]) -> u32 {
    let bits =
        resources.crtcs().iter().enumerate().filter(|(_, crtc)| able.contains(crtc)).map(|(index, _)| 1 << index);
    bits.fold(0, |mask, bit: u32| mask | bit)
}

/// The handle of the object `id`.
/// Errors: `ENOENT` if it is none.
pub(super) fn handle<T: From<drm::control::RawResourceHandle>>(id: Id) -> io::Result<T> {
    from_u32(id.0).ok_or_else(|| Errno::NOENT.into())
}

/// Calls again as long as a signal interrupts.
pub(super) fn uninterrupted<T>(mut call: impl FnMut() -> io::Result<T>) -> io::Result<T> {
    loop {
        match call() {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            done => return done,
        }
    }
}
