// The chaos game on a GPU: each invocation carries one orbit on for some steps, and counts where it is.
//
// What the numbers of `plans` mean, `program.rs` says; the functions `moved` and `seen_through` and the polynomials are
// written by it. `frame.rs` fills the buffers. The game is that of `chaos.rs` and `pool.rs`.

struct Frame {
    // Cells in a row and in a column.
    width: u32,
    height: u32,
    // The first step of each orbit that is taken now, how many are, and how many are not seen when an orbit begins.
    first: u32,
    count: u32,
    fuse: u32,
    // Orbits of a stream; the streams of the frame.
    orbits_of_stream: u32,
    streams: u32,
    // Steps of the frame.
    steps: u32,
    // Moments of the frame, and one that does not begin after the first step.
    moments: u32,
    moment: u32,
    // Orbits of all streams.
    orbits: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> plans: array<u32>;
@group(0) @binding(2) var<storage, read> palette: array<vec4u>;
@group(0) @binding(3) var<storage, read_write> orbits: array<u32>;
@group(0) @binding(4) var<storage, read_write> sums: array<atomic<u32>>;
@group(0) @binding(5) var<storage, read_write> carried: array<atomic<u32>>;

// The generator of this orbit: xoshiro128++.
var<private> random: vec4u;

fn number(at: u32) -> f32 {
    return bitcast<f32>(plans[at]);
}

fn bits() -> u32 {
    var s = random;
    let sum = s.x + s.w;
    let out = ((sum << 7u) | (sum >> 25u)) + s.x;
    let shifted = s.y << 9u;
    s.z ^= s.x;
    s.w ^= s.y;
    s.y ^= s.z;
    s.x ^= s.w;
    s.z ^= shifted;
    s.w = (s.w << 11u) | (s.w >> 21u);
    random = s;
    return out;
}

// In 0.0..1.0.
fn unit() -> f32 {
    return f32(bits() >> 8u) * 0x1p-24f;
}

fn coin() -> bool {
    return (bits() >> 31u) == 1u;
}

// In -1.0..1.0.
fn signed() -> f32 {
    return unit() * 2f - 1f;
}

fn with_sign(value: f32, sign: f32) -> f32 {
    return bitcast<f32>((bitcast<u32>(value) & 0x7fffffffu) | (bitcast<u32>(sign) & 0x80000000u));
}

// The sine and the cosine.
fn sin_cos(whole: f32) -> vec2f {
    var angle = whole;
    if abs(whole) > 4194304f {
        // Neighbouring numbers are so far apart that an angle is as good as random; this is one.
        angle = f32(bitcast<i32>(bitcast<u32>(whole) * 0x9e3779b9u)) * (6.2831855f / 4294967296f);
    }
    let quarters = round(angle * 0.63661975f);
    let turned = bitcast<u32>(i32(quarters));
    let r = fma(quarters, -LACKING, fma(quarters, -1.5707964f, angle));
    let r2 = r * r;
    let sine = fma(series_sin(r2) * r2, r, r);
    let cosine = fma(series_cos(r2), r2 * r2, fma(r2, -0.5f, 1f));
    let even = (turned & 1u) == 0u;
    let s = bitcast<u32>(select(cosine, sine, even)) ^ ((turned & 2u) << 30u);
    let c = bitcast<u32>(select(sine, cosine, even)) ^ (((turned + 1u) & 2u) << 30u);
    return vec2f(bitcast<f32>(s), bitcast<f32>(c));
}

// The angle of the point (x, y).
fn angle(y: f32, x: f32) -> f32 {
    let far = abs(x);
    let high = abs(y);
    let steep = far < high;
    // Never 0 divided by 0.
    let slope = select(high, far, steep) / max(select(far, high, steep), 0x1p-126f);
    let square = slope * slope;
    var angle = fma(series_atan(square) * square, slope, slope);
    angle = select(angle, 1.5707964f - angle, steep);
    angle = select(angle, 3.1415927f - angle, x < 0f);
    return with_sign(angle, y);
}

// To base 2.
fn logarithm(value: f32) -> f32 {
    let bits = bitcast<i32>(max(value, 0x1p-126f));
    let exponent = (bits - HALF_ROOT) >> 23u;
    let m = bitcast<f32>(bits - (exponent << 23u)) - 1f;
    let square = m * m;
    let natural = fma(series_log(m) * m, square, fma(square, -0.5f, m));
    return fma(natural, 1.442695f, f32(exponent));
}

fn power_of_2(exponent: f32) -> f32 {
    let x = min(max(exponent, -126f), 127f);
    let whole = round(x);
    return bitcast<f32>(bitcast<i32>(series_exp2(x - whole)) + (i32(whole) << 23u));
}

// The image of a point by the six numbers from `at` on.
fn affine(at: u32, x: f32, y: f32) -> vec2f {
    return vec2f(
        fma(x, number(at), fma(y, number(at + 1u), number(at + 2u))),
        fma(x, number(at + 3u), fma(y, number(at + 4u), number(at + 5u))),
    );
}

// Whether a point is on the plane still. By its bits: a compiler may take for granted that there are no infinite numbers.
fn is_kept(point: vec2f) -> bool {
    let far = bitcast<vec2u>(point) & vec2u(0x7fffffffu);
    return all(far < vec2u(bitcast<u32>(1e10f)));
}

// Adds to a sum of 64 bits. Sums never overflow, whatever the order is in which invocations come.
fn add(at: u32, light: u32) {
    let before = atomicAdd(&sums[at], light);
    if before + light < before {
        atomicAdd(&carried[at], 1u);
    }
}

fn plot(plan: u32, chosen: u32, unseen: vec2f, unseen_colour: f32) {
    if plans[chosen + IS_SEEN] == 0u {
        return;
    }
    var point = unseen;
    var colour = unseen_colour;
    let lens = plans[plan + LENS];
    if lens != 0u {
        let opacity = number(lens + OPACITY);
        if opacity >= 1f || unit() < opacity {
            point = seen_through(plans[lens + PROGRAM], point.x, point.y, lens + NUMBERS);
            colour = fma(colour, number(lens + KEEP), number(lens + PULL));
            if !is_kept(point) {
                point = vec2f(signed(), signed());
            }
        }
    }
    let part = number(chosen + PART);
    if part < 1f && unit() >= part {
        return;
    }
    let place = affine(plan + TO_CELLS, point.x, point.y);
    if !(place.x >= 0f && place.y >= 0f && place.x < f32(frame.width) && place.y < f32(frame.height)) {
        return;
    }
    let cell = u32(place.y) * frame.width + u32(place.x);
    let entry = min(u32(max(colour, 0f) * f32(ENTRIES)), ENTRIES - 1u);
    let light = palette[plans[chosen + FIRST_ENTRY] + entry];
    add(4u * cell, light.x);
    add(4u * cell + 1u, light.y);
    add(4u * cell + 2u, light.z);
    add(4u * cell + 3u, light.w);
}

// The number of the next transform after number `last`.
fn choice(plan: u32, last: u32) -> u32 {
    let drawn = bits();
    let thresholds = plans[plan + THRESHOLDS] + last * plans[plan + THRESHOLDS_ON];
    var low = 0u;
    var high = plans[plan + MOVES] - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if drawn >= plans[thresholds + middle] {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

@compute @workgroup_size(WORKGROUP)
fn draw(@builtin(global_invocation_id) id: vec3u) {
    let orbit = id.x;
    let all = frame.orbits;
    if orbit >= all {
        return;
    }
    // One word of all orbits lies beside the other, so that neighbours read neighbours.
    var point = vec2f(bitcast<f32>(orbits[orbit]), bitcast<f32>(orbits[all + orbit]));
    var colour = bitcast<f32>(orbits[2u * all + orbit]);
    var last = orbits[3u * all + orbit];
    random = vec4u(
        orbits[4u * all + orbit], orbits[5u * all + orbit], orbits[6u * all + orbit], orbits[7u * all + orbit]);
    var samples = orbits[8u * all + orbit];

    let stream = orbit / frame.orbits_of_stream;
    var moment = frame.moment;
    for (var i = 0u; i < frame.count; i++) {
        let taken = frame.first + i;
        let step = (max(taken, frame.fuse) - frame.fuse) * frame.streams + stream;
        if step >= frame.steps {
            break;
        }
        // The same for all orbits of a workgroup.
        while moment + 1u < frame.moments && plans[2u * moment + 2u] <= step {
            moment++;
        }
        let plan = plans[2u * moment + 1u];
        last = choice(plan, last);
        let chosen = plans[plan + FIRST_MOVE + last];
        point = moved(plans[chosen + PROGRAM], point.x, point.y, chosen + NUMBERS);
        colour = fma(colour, number(chosen + KEEP), number(chosen + PULL));
        if !is_kept(point) {
            point = vec2f(signed(), signed());
        } else if taken >= frame.fuse {
            samples++;
            plot(plan, chosen, point, colour);
        }
    }

    orbits[orbit] = bitcast<u32>(point.x);
    orbits[all + orbit] = bitcast<u32>(point.y);
    orbits[2u * all + orbit] = bitcast<u32>(colour);
    orbits[3u * all + orbit] = last;
    orbits[4u * all + orbit] = random.x;
    orbits[5u * all + orbit] = random.y;
    orbits[6u * all + orbit] = random.z;
    orbits[7u * all + orbit] = random.w;
    orbits[8u * all + orbit] = samples;
}
