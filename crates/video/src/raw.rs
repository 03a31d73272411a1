//! The fence around ffmpeg: every `unsafe` block of this crate, behind types that are safe to use.
//!
//! Owns the lifetimes of ffmpeg's contexts, packets and frames, and the rule that no enum of ffmpeg is read from memory
//! that a file could have shaped. It decides nothing: it returns [`Code`]s and plain numbers. Reading goes through
//! `ffmpeg-next`'s bindings, because its safe layer does not report damaged frames and panics on file names that are
//! not UTF-8; writing uses that safe layer, in `encoder.rs`.
//!
//! Next: `probe.rs` and `clip.rs` read packets with it, `session.rs` decodes them.
#![allow(unsafe_code)]

use crate::code::{Code, check};
use crate::probe::Sample;
use ffmpeg_next::ffi as av;
use ffmpeg_next::format::Pixel;
use ffmpeg_next::frame::Video;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::ptr::{self, NonNull};
use std::slice;
use std::sync::atomic::{AtomicU32, Ordering};

/// ffmpeg's message for an error code.
pub(crate) fn error_text(answer: c_int) -> String {
    let mut text = [0u8; 96];
    // SAFETY: `text` is writable for the length given; ffmpeg always ends it with a 0 within that length.
    unsafe { av::av_strerror(answer, text.as_mut_ptr().cast(), text.len()) };
    CStr::from_bytes_until_nul(&text).map_or("unknown error".into(), CStr::to_string_lossy).into_owned()
}

/// A path as a URL of ffmpeg's file protocol, so that no name is taken for another protocol.
fn url(path: &Path) -> Result<CString, Code> {
    CString::new([b"file:", path.as_os_str().as_bytes()].concat()).map_err(|_| Code::INVALID)
}

/// Keeps ffmpeg's messages off stderr, and counts the errors of decoders.
pub(crate) fn redirect_log() {
    // SAFETY: sets one atomic pointer inside ffmpeg, to a function that lives for ever and may run on any thread.
    unsafe { av::av_log_set_callback(Some(log_callback)) };
}

/// ffmpeg's log callback. Each error of a [`Decoder`] is added to its clip's count: with several threads ffmpeg 5.1
/// reports concealed errors in no other way. `Arguments` is the C compiler's `va_list`, never touched.
unsafe extern "C" fn log_callback<Arguments>(who: *mut c_void, level: c_int, _: *const c_char, _: Arguments) {
    if who.is_null() || level & 0xff > av::AV_LOG_ERROR {
        return;
    }
    // SAFETY: ffmpeg hands out objects whose first field is their class; those of class `AVCodecContext` are one. Its
    // `opaque` is null but where `Decoder::send` set it to a counter, which outlives the context and its threads.
    unsafe {
        if *who.cast::<*const av::AVClass>() == av::avcodec_get_class() {
            let counter = (*who.cast::<av::AVCodecContext>()).opaque.cast::<AtomicU32>();
            if let Some(counter) = counter.as_ref() {
                counter.fetch_add(1, Ordering::Relaxed);
            }
        }
    }
}

/// An open MP4 file and its one video stream.
pub(crate) struct Demuxer {
    context: NonNull<av::AVFormatContext>,
    stream: NonNull<av::AVStream>,
}

// SAFETY: the contexts have no tie to a thread; `Demuxer` owns them alone and every call takes `&mut self` or reads.
unsafe impl Send for Demuxer {}

impl Demuxer {
    /// Reads the header of `path`, which must be MP4 or its ancestor MOV.
    pub(crate) fn open(path: &Path) -> Result<Self, Code> {
        redirect_log();
        let url = url(path)?;
        // SAFETY: plain lookups and an allocation; the context is freed by `avformat_open_input` if that fails.
        let context = unsafe {
            let format = av::av_find_input_format(c"mov".as_ptr());
            let mut context = av::avformat_alloc_context();
            if context.is_null() {
                return Err(Code::NO_MEMORY);
            }
            // The clip's own timestamps, not what a parser would guess.
            (*context).flags |= av::AVFMT_FLAG_NOPARSE | av::AVFMT_FLAG_NOFILLIN;
            let mut options = ptr::null_mut();
            av::av_dict_set(&raw mut options, c"protocol_whitelist".as_ptr(), c"file".as_ptr(), 0);
            let opened = av::avformat_open_input(&raw mut context, url.as_ptr(), format, &raw mut options);
            av::av_dict_free(&raw mut options);
            check(opened)?;
            NonNull::new(context).ok_or(Code::NO_MEMORY)?
        };
        // SAFETY: an opened context lists `nb_streams` streams, each with parameters, all alive as long as it is.
        unsafe {
            // A damaged index may name none, and there is no list then.
            let streams = NonNull::new((*context.as_ptr()).streams);
            let count = (*context.as_ptr()).nb_streams as usize;
            let streams = streams.map_or(&[][..], |first| slice::from_raw_parts(first.as_ptr(), count));
            let is_video = |s: &*mut av::AVStream| (*(**s).codecpar).codec_type == av::AVMediaType::AVMEDIA_TYPE_VIDEO;
            let Some(stream) = streams.iter().copied().find(is_video).and_then(NonNull::new) else {
                av::avformat_close_input(&mut context.as_ptr());
                return Err(Code::of(av::AVERROR_STREAM_NOT_FOUND));
            };
            for other in streams.iter().filter(|s| **s != stream.as_ptr()) {
                (**other).discard = av::AVDiscard::AVDISCARD_ALL;
            }
            Ok(Self { context, stream })
        }
    }

    /// The codec's short name: `h264`.
    pub(crate) fn codec(&self) -> String {
        // SAFETY: the stream lives as long as `self`; the name is a static string for any id.
        unsafe {
            CStr::from_ptr(av::avcodec_get_name((*(*self.stream.as_ptr()).codecpar).codec_id)).to_string_lossy().into()
        }
    }

    /// Width and height as the container tells them.
    pub(crate) fn size(&self) -> (u32, u32) {
        // SAFETY: the stream and its parameters live as long as `self`.
        let parameters = unsafe { &*(*self.stream.as_ptr()).codecpar };
        (parameters.width.max(0).unsigned_abs(), parameters.height.max(0).unsigned_abs())
    }

    /// The codec's configuration record (`avcC`); empty where there is none.
    pub(crate) fn configuration(&self) -> &[u8] {
        // SAFETY: the stream and its parameters live as long as `self`; ffmpeg keeps `extradata_size` bytes there.
        unsafe {
            let parameters = &*(*self.stream.as_ptr()).codecpar;
            match (NonNull::new(parameters.extradata), usize::try_from(parameters.extradata_size)) {
                (Some(data), Ok(bytes)) => slice::from_raw_parts(data.as_ptr(), bytes),
                (None, _) | (_, Err(_)) => &[],
            }
        }
    }

    /// Seconds per tick as numerator and denominator, both at least 1.
    pub(crate) fn time_base(&self) -> (u32, u32) {
        // SAFETY: the stream lives as long as `self`.
        let base = unsafe { (*self.stream.as_ptr()).time_base };
        (base.num.max(1).unsigned_abs(), base.den.max(1).unsigned_abs())
    }

    /// What the container's index lists, in decoding order.
    pub(crate) fn samples(&self) -> Vec<Sample> {
        // SAFETY: the index belongs to the stream, which lives as long as `self`; `n` is below its length.
        let entry = |n| unsafe { av::avformat_index_get_entry(self.stream.as_ptr(), n).as_ref() };
        // SAFETY: as above.
        let count = unsafe { av::avformat_index_get_entries_count(self.stream.as_ptr()) };
        let sample = |e: &av::AVIndexEntry| Sample {
            offset: u64::try_from(e.pos).unwrap_or(u64::MAX),
            bytes: u64::try_from(e.size()).unwrap_or(0),
            dts: e.timestamp,
            shown: e.flags() & av::AVINDEX_DISCARD_FRAME == 0,
            key: e.flags() & av::AVINDEX_KEYFRAME != 0,
        };
        (0..count).filter_map(entry).map(sample).collect()
    }

    /// Goes to the keyframe at or before `time`, in ticks; where pictures are reordered it may be one after it.
    pub(crate) fn seek(&mut self, time: i64) -> Result<(), Code> {
        // SAFETY: context and stream are alive and exclusively ours.
        let answer = unsafe {
            let stream = (*self.stream.as_ptr()).index;
            av::av_seek_frame(self.context.as_ptr(), stream, time, av::AVSEEK_FLAG_BACKWARD)
        };
        check(answer).map(drop)
    }

    /// The next packet of the video stream into `packet`; `false` at the end of the file.
    pub(crate) fn read(&mut self, packet: &mut Packet) -> Result<bool, Code> {
        loop {
            packet.clear();
            // SAFETY: both contexts are alive and exclusively ours; `packet` is blank and takes a reference.
            match unsafe { av::av_read_frame(self.context.as_ptr(), packet.0.as_ptr()) } {
                av::AVERROR_EOF => return Ok(false),
                answer => check(answer)?,
            };
            // SAFETY: as above.
            if unsafe { (*packet.0.as_ptr()).stream_index == (*self.stream.as_ptr()).index } {
                return Ok(true);
            }
        }
    }
}

impl Drop for Demuxer {
    fn drop(&mut self) {
        // SAFETY: the context was opened in `open` and is closed only here.
        unsafe { av::avformat_close_input(&mut self.context.as_ptr()) };
    }
}

/// One compressed picture.
pub(crate) struct Packet(NonNull<av::AVPacket>);

// SAFETY: a packet's memory has no tie to a thread and its counts are atomic; `Packet` owns its reference alone.
unsafe impl Send for Packet {}

impl Packet {
    pub(crate) fn new() -> Result<Self, Code> {
        // SAFETY: an allocation that answers null when there is no memory.
        NonNull::new(unsafe { av::av_packet_alloc() }).map(Self).ok_or(Code::NO_MEMORY)
    }

    /// A reference to the same bytes, which are copied only if one of the two is changed.
    pub(crate) fn clone_ref(&self) -> Result<Self, Code> {
        let clone_ref = Self::new()?;
        // SAFETY: both were allocated in `new` and are freed only in `drop`; the clone_ref is ours alone and holds nothing.
        check(unsafe { av::av_packet_ref(clone_ref.0.as_ptr(), self.0.as_ptr()) })?;
        Ok(clone_ref)
    }

    /// Gives its bytes back.
    pub(crate) fn clear(&mut self) {
        // SAFETY: allocated in `new`, freed only in `drop`.
        unsafe { av::av_packet_unref(self.0.as_ptr()) };
    }

    /// Presentation time in ticks of the demuxer's time base.
    pub(crate) fn pts(&self) -> Option<i64> {
        // SAFETY: allocated in `new`, freed only in `drop`.
        let pts = unsafe { (*self.0.as_ptr()).pts };
        (pts != av::AV_NOPTS_VALUE).then_some(pts)
    }

    /// Replaces the timestamps by one number of ours, which comes back as [`Picture::tag`].
    pub(crate) fn set_tag(&mut self, tag: Option<i64>) {
        // SAFETY: allocated in `new`, freed only in `drop`; exclusively borrowed.
        let packet = unsafe { self.0.as_mut() };
        packet.pts = tag.unwrap_or(av::AV_NOPTS_VALUE);
        packet.dts = av::AV_NOPTS_VALUE;
        packet.duration = 0;
    }

    /// Whether the demuxer already knows that bytes are missing.
    pub(crate) fn is_corrupt(&self) -> bool {
        // SAFETY: allocated in `new`, freed only in `drop`.
        unsafe { (*self.0.as_ptr()).flags & av::AV_PKT_FLAG_CORRUPT != 0 }
    }

    /// Whether it is decoded but not shown: an edit list discards it.
    pub(crate) fn is_discarded(&self) -> bool {
        // SAFETY: allocated in `new`, freed only in `drop`.
        unsafe { (*self.0.as_ptr()).flags & av::AV_PKT_FLAG_DISCARD != 0 }
    }

    /// Its bytes, ours alone to change.
    pub(crate) fn bytes_mut(&mut self) -> Result<&mut [u8], Code> {
        // SAFETY: after `av_packet_make_writable` nobody else refers to the `size` bytes at `data`; the borrow of
        // `self` keeps both in place.
        unsafe {
            if (*self.0.as_ptr()).data.is_null() {
                return Ok(&mut []);
            }
            check(av::av_packet_make_writable(self.0.as_ptr()))?;
            let packet = self.0.as_mut();
            Ok(slice::from_raw_parts_mut(packet.data, usize::try_from(packet.size).unwrap_or(0)))
        }
    }
}

impl Drop for Packet {
    fn drop(&mut self) {
        // SAFETY: allocated in `new`, freed only here.
        unsafe { av::av_packet_free(&mut self.0.as_ptr()) };
    }
}

/// A decoded picture, immutable once the decoder has returned it.
pub(crate) struct Picture(NonNull<av::AVFrame>);

// SAFETY: nothing writes to a picture once `Decoder::receive` returned it (the decoder only reads it as a reference),
// its counts are atomic, and its buffer pool takes a lock when the last reference goes, on whichever thread.
unsafe impl Send for Picture {}
// SAFETY: as above; every method only reads.
unsafe impl Sync for Picture {}

impl Picture {
    fn frame(&self) -> &av::AVFrame {
        // SAFETY: allocated in `Decoder::receive`, freed only in `drop`.
        unsafe { self.0.as_ref() }
    }

    /// The number given to the packet it came from.
    pub(crate) fn tag(&self) -> Option<i64> {
        let pts = self.frame().pts;
        (pts != av::AV_NOPTS_VALUE).then_some(pts)
    }

    /// Visible width and height.
    pub(crate) fn size(&self) -> (u32, u32) {
        (self.frame().width.max(0).unsigned_abs(), self.frame().height.max(0).unsigned_abs())
    }

    /// Whether the samples are 8-bit planar 4:2:0, the only layout that [`Picture::planes`] reads.
    pub(crate) fn is_yuv420p(&self) -> bool {
        let format = self.frame().format;
        (format == av::AVPixelFormat::AV_PIX_FMT_YUV420P as c_int
            || format == av::AVPixelFormat::AV_PIX_FMT_YUVJ420P as c_int)
            && self.frame().linesize[..3].iter().all(|stride| *stride > 0)
            && self.frame().data[..3].iter().all(|data| !data.is_null())
    }

    /// Whether errors in it were concealed.
    pub(crate) fn is_damaged(&self) -> bool {
        self.frame().decode_error_flags != 0 || self.frame().flags & av::AV_FRAME_FLAG_CORRUPT != 0
    }

    /// ffmpeg's `AVVideoEncParams` and its blocks; empty unless the decoder was asked for it.
    pub(crate) fn encoding(&self) -> &[u8] {
        // SAFETY: only read; ffmpeg keeps `size` bytes at `data` for as long as the frame is referenced.
        unsafe {
            let kind = av::AVFrameSideDataType::AV_FRAME_DATA_VIDEO_ENC_PARAMS;
            let data = av::av_frame_get_side_data(self.frame(), kind).as_ref();
            data.map_or(&[], |data| slice::from_raw_parts(data.data, data.size))
        }
    }

    /// Y, U and V from their first to their last visible byte; empty if it is not [`Picture::is_yuv420p`].
    pub(crate) fn planes(&self) -> [&[u8]; 3] {
        if !self.is_yuv420p() {
            return [&[]; 3];
        }
        let (width, height) = self.size();
        [0usize, 1, 2].map(|plane| {
            let chroma = u32::from(plane > 0);
            let [width, height] = [width, height].map(|side| (side + chroma) as usize >> chroma);
            let bytes = if height == 0 { 0 } else { self.strides()[plane] * (height - 1) + width };
            // SAFETY: `is_yuv420p` has made sure of the layout: ffmpeg keeps `height` rows of `width` bytes, one
            // every `linesize` bytes, at `data`, for as long as the frame is referenced.
            unsafe { slice::from_raw_parts(self.frame().data[plane], bytes) }
        })
    }

    /// Bytes from one row to the next of Y, U and V.
    pub(crate) fn strides(&self) -> [usize; 3] {
        [0, 1, 2].map(|plane| usize::try_from(self.frame().linesize[plane]).unwrap_or(0))
    }
}

impl Drop for Picture {
    fn drop(&mut self) {
        // SAFETY: allocated in `Decoder::receive`, freed only here.
        unsafe { av::av_frame_free(&mut self.0.as_ptr()) };
    }
}

/// What a pixel format is: ffmpeg's flags, and the bits of each kind of samples.
pub(crate) fn pixel_format(format: Pixel) -> Option<(u64, Vec<u32>)> {
    let descriptor = format.descriptor()?.as_ptr();
    // SAFETY: ffmpeg's descriptors are constants.
    let av::AVPixFmtDescriptor { flags, comp, nb_components, .. } = unsafe { &*descriptor };
    Some((*flags, comp.iter().take((*nb_components).into()).map(|kind| kind.depth.max(0).unsigned_abs()).collect()))
}

/// Reads row `y` of the samples of `kind` from a decoded picture; `row` is as long as that. Of other rows, and of kinds
/// that its format has not, nothing is read.
pub(crate) fn read_row(frame: &Video, kind: u8, y: u32, row: &mut [u16]) {
    let Some(format) = frame.format().descriptor().filter(|format| kind < format.nb_components()) else { return };
    let [across, down] = if matches!(kind, 1 | 2) { [format.log2_chroma_w(), format.log2_chroma_h()] } else { [0; 2] };
    if row.len() != frame.width().div_ceil(1 << across) as usize || y >= frame.height().div_ceil(1 << down) {
        return;
    }
    let to = row.as_mut_ptr().cast();
    // SAFETY: a decoded frame keeps all rows of its format at `data`, `linesize` bytes apart, also where that is negative;
    // row, kind and width were checked above, and `row` has two bytes for each sample.
    unsafe {
        let (data, strides) = ((*frame.as_ptr()).data, (*frame.as_ptr()).linesize);
        let (mut data, width) = (data.map(<*mut u8>::cast_const), row.len() as c_int);
        let (data, strides) = (data.as_mut_ptr(), strides.as_ptr());
        av::av_read_image_line2(to, data, strides, format.as_ptr(), 0, y as c_int, kind.into(), width, 0, 2);
    }
}

/// The result of sending a packet to the decoder.
pub(crate) enum SendResult {
    /// It is in.
    Taken,
    /// Pictures must come out first; offer it again.
    Full,
    /// It is in, and one packet, this or the one [`Decoder::lag`] before it, could not be decoded.
    Failed(Code),
}

/// The result of receiving from the decoder.
pub(crate) enum ReceiveResult {
    Picture(Picture),
    /// It wants a packet first.
    NeedsInput,
    /// All is out after the end was announced.
    End,
    /// A packet could not be decoded.
    Failed(Code),
}

/// For how many clips a decoder counts errors: more than can be inside it, with one frame per thread.
const MAX_CLIPS: usize = 256;

/// An H.264 decoder.
pub(crate) struct Decoder {
    context: NonNull<av::AVCodecContext>,
    /// Errors per clip, by its number modulo [`MAX_CLIPS`]. Freed after `context`, see `drop`.
    error_count: Box<[AtomicU32; MAX_CLIPS]>,
}

// SAFETY: a codec context may move between threads as long as one uses it at a time: every method takes `&mut self`.
unsafe impl Send for Decoder {}

impl Decoder {
    /// A decoder that works on `threads` pictures at a time, and tells their [`Picture::encoding`] if `encoding`.
    pub(crate) fn new(threads: usize, encoding: bool) -> Result<Self, Code> {
        redirect_log();
        // SAFETY: lookups and an allocation, checked for null before use.
        let context = unsafe {
            let codec = av::avcodec_find_decoder(av::AVCodecID::AV_CODEC_ID_H264);
            if codec.is_null() {
                return Err(Code::of(av::AVERROR_DECODER_NOT_FOUND));
            }
            (NonNull::new(av::avcodec_alloc_context3(codec)).ok_or(Code::NO_MEMORY)?, codec)
        };
        let (context, codec) = context;
        let error_count = Box::new([const { AtomicU32::new(0) }; MAX_CLIPS]);
        let mut decoder = Self { context, error_count };
        // SAFETY: the context is alive and exclusively ours, not yet open.
        unsafe {
            let context = decoder.context.as_mut();
            context.thread_count = c_int::try_from(threads).unwrap_or(c_int::MAX);
            context.thread_type = av::FF_THREAD_FRAME;
            context.export_side_data = if encoding { av::AV_CODEC_EXPORT_DATA_VIDEO_ENC_PARAMS } else { 0 };
            check(av::avcodec_open2(context, codec, ptr::null_mut()))?;
        }
        Ok(decoder)
    }

    /// After how many packets the error of a bad one is reported.
    pub(crate) fn lag(&self) -> usize {
        // SAFETY: allocated in `new`, freed only in `drop`.
        let context = unsafe { self.context.as_ref() };
        let threaded = context.active_thread_type & av::FF_THREAD_FRAME != 0;
        if threaded { usize::try_from(context.thread_count - 1).unwrap_or(0) } else { 0 }
    }

    /// Sends a packet of the `clip`th clip.
    pub(crate) fn send(&mut self, packet: &Packet, clip: u64) -> SendResult {
        let counter = &raw const self.error_count[counter_index(clip)];
        // SAFETY: the context is open and exclusively ours; the packet is alive and only read. ffmpeg copies `opaque`,
        // never follows it; `log_callback` does, and the counter stays in place until `drop` has ended all threads.
        let answer = unsafe {
            let before = self.context.as_ref().opaque;
            self.context.as_mut().opaque = counter.cast_mut().cast();
            let answer = av::avcodec_send_packet(self.context.as_ptr(), packet.0.as_ptr());
            if answer == av::AVERROR(av::EAGAIN) {
                self.context.as_mut().opaque = before;
            }
            answer
        };
        match answer {
            answer if answer >= 0 => SendResult::Taken,
            answer if answer == av::AVERROR(av::EAGAIN) => SendResult::Full,
            answer => SendResult::Failed(Code::of(answer)),
        }
    }

    /// Signals the end of the stream.
    pub(crate) fn send_end(&mut self) {
        // SAFETY: the context is open and exclusively ours; no packet is ffmpeg's sign for the end.
        unsafe { av::avcodec_send_packet(self.context.as_ptr(), ptr::null()) };
    }

    /// Errors of the `clip`th clip since the last call.
    pub(crate) fn error_count(&self, clip: u64) -> u32 {
        self.error_count[counter_index(clip)].swap(0, Ordering::Relaxed)
    }

    /// Takes the next picture out.
    pub(crate) fn receive(&mut self) -> ReceiveResult {
        // SAFETY: an allocation, checked for null; the context is open and fills the blank frame with references.
        unsafe {
            let Some(frame) = NonNull::new(av::av_frame_alloc()) else { return ReceiveResult::Failed(Code::NO_MEMORY) };
            let picture = Picture(frame);
            match av::avcodec_receive_frame(self.context.as_ptr(), frame.as_ptr()) {
                answer if answer >= 0 => ReceiveResult::Picture(picture),
                answer if answer == av::AVERROR(av::EAGAIN) => ReceiveResult::NeedsInput,
                av::AVERROR_EOF => ReceiveResult::End,
                answer => ReceiveResult::Failed(Code::of(answer)),
            }
        }
    }
}

impl Drop for Decoder {
    fn drop(&mut self) {
        // SAFETY: allocated in `new`, freed only here; frames that are still out keep their own references.
        // It joins the threads; only then does the counter's memory go.
        unsafe { av::avcodec_free_context(&mut self.context.as_ptr()) };
    }
}

fn counter_index(clip: u64) -> usize {
    usize::try_from(clip % MAX_CLIPS as u64).unwrap_or(0)
}
