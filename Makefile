# What one does here. `make` alone says what they are.
# What a target needs from the distribution it installs itself, once: the lists lie in .ci/packages.

.DEFAULT_GOAL := help
.PHONY: help play check check-all gpu bench soak crash image boot tests slow bench-image

programs := $(or $(CARGO_TARGET_DIR),target)/release
# One choice of packages, and so of their features, for every command: nothing is compiled twice.
all := --locked --workspace
# Where a player that was started from here keeps its place in the path, and its flock.
state := target/play
# The programs that a unit gets, where `image-build/programs` lays them. What is tried and measured is these.
unit := target/unit
# Where programs with the feature `gpu` are built, so that those without it stay as they are.
gpu := $(CURDIR)/target/gpu
# The flock of the claims' image, and whose systems that takes.
light := target/light-flock
artist := tests/fixtures/keys/artist.pub
claims := --profile bench --flock $(light) --key $(artist)
slow bench soak crash: export DREAMS_PROGRAMS := $(CURDIR)/$(unit)/bin

# What is made for another architecture lies beside what is made for this one.
beside := $(addprefix -,$(filter arm64,$(arch)))

help: ## say what each target does
	@sed -n 's/^\([a-z-]*\):.*## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 16

play: ## build the player and show the demo flock on the best screen there is, rendered better meanwhile; Ctrl-C ends it
	.ci/install play
	cargo build $(all) --release --bin dreams-player
	BUILD='cargo build $(all) --release --bin dreams --bin dreams-video' \
	  flock-tools/demo/play '$(programs)/dreams-player' '$(programs)/dreams' flock-tools/demo/small $(state)

check: ## what must hold before each commit: form, lints, licences, types, unit tests, the claims on the programs; what='updates:: house::' for the tests with these words in their names alone
	.ci/install play check
	cargo fmt --check
	cargo clippy $(all) --all-targets -- --deny warnings
	if cargo deny --version >/dev/null 2>&1; then cargo deny check licenses bans sources; fi
	$(MAKE) --no-print-directory tests

# The first tier: the tests in the packages and in each one's `tests/it`. `tests/it/house/tiers.rs` holds what is in which.
# Many of them wait: four at once keep two processors busy.
tests:
	cargo build $(all) --bins --tests
	cargo test $(all) --doc
	RUST_TEST_THREADS=4 cargo test $(all) --lib --bins --test it --no-fail-fast$(if $(what), -- $(what))

check-all: ## what must hold before a change lands: `check`, and whatever needs guest kernels, emulated units, a browser or a cluster
	$(MAKE) --no-print-directory check
	.ci/install check-all image
	$(MAKE) --no-print-directory bench-image
	$(MAKE) --no-print-directory slow

# The second tier, on the programs that the image holds; with them, the claims of the first tier on a unit's programs, too,
# and the balance on five times as many flocks. Both lines run, whatever the first one finds.
slow:
	FLOCKS=10000 cargo test $(all) --test it --no-fail-fast -- player:: unit:: updates:: balances::; \
	first=$$?; cargo test $(all) --test slow --test image --no-fail-fast && exit $$first

# The programs of a unit, and the image that holds them.
bench-image:
	image-build/programs $(unit)
	tests/image/light-flock flock-tools/demo/small $(light)
	image-build/build target/image $(claims)

gpu: ## build `dreams` with `render --on gpu`, and hold its pictures against the processor's, on the GPU or the software driver that Vulkan knows
	.ci/install play check gpu
	cargo clippy --locked --release --package flame --package dreams --features gpu --all-targets --target-dir $(gpu) -- --deny warnings
	cargo build --locked --release --package dreams --features gpu --target-dir $(gpu)
	cargo test --locked --release --package dreams --features gpu --test gpu --target-dir $(gpu)
	cargo test --locked --release --package flame --features gpu --lib --test it --target-dir $(gpu) -- gpu::

bench: ## measure what is promised about speed beside our peers; what=graph, suggestions, walk, flames, genomes, species, breeding, quality, gpu, import, bundles, studio, display or boot for one part
	.ci/install play check check-all bench image
	cargo build --locked --release --workspace --exclude player
	$(MAKE) --no-print-directory bench-image
	tests/bench/run $(what)

soak: ## the claims that take hours; what=walks, flames, species, breeding, studio, damages, arm64, day, update, package, twice or fresh for one part
	.ci/install play check check-all image arm64
	cargo build --locked --release --workspace
	image-build/programs $(unit)
	tests/soak/run $(what)

crash: ## cut the power where it hurts: 10,000 states that a disk may be left in, and a whole machine a hundred times; 20,000 mutants of a stick; and all other claims on whole machines
	.ci/install play check check-all image arm64
	cargo build --locked --release --workspace --exclude player
	image-build/programs $(unit)
	tests/crash/run
	MUTANTS=20000 cargo test --locked --release --package claims --test it -- --nocapture mutants::
	tests/image/light-flock flock-tools/demo/small $(light)
	image-build/build target/image $(claims)
	ARCH=arm64 image-build/programs $(unit)-arm64
	ARCH=arm64 image-build/build target/image-arm64 $(claims)
	cargo test --locked --release --package claims --bench image-whole -- --nocapture --skip boot_time::

image: export ARCH := $(arch)
image: ## build the bootable image of a unit; keys="A.pub B.pub", url=ADDRESS and version=0.2.0 say whose flocks it takes, where it looks, and what it is; flock=DIR what it plays until it is sent one; owner=FILE the settings of all units with this image; installer=yes for a stick that installs the unit on the disk of a computer, after a press of Enter; system_keys="C.pub" takes systems from these alone; profile=bench for one with a shell on the serial port, sign=KEYS to sign what the firmware starts; arch=arm64 for ARM processors and Raspberry Pis
	.ci/install image $(filter arm64,$(arch))
	image-build/programs $(unit)$(beside)
	image-build/build target/image$(beside) --profile $(or $(profile),unit) $(addprefix --key ,$(keys)) $(addprefix --system-key ,$(system_keys)) $(if $(url),--url '$(url)') $(if $(version),--version '$(version)') $(if $(flock),--flock '$(flock)') $(if $(owner),--owner '$(owner)') $(if $(installer),--installer) $(if $(sign),--sign '$(sign)')

boot: ## start the image under QEMU: in a window, or without a display a picture of it in target/image/boot.png
	$(MAKE) image profile=bench
	[ -z "$$DISPLAY$$WAYLAND_DISPLAY" ] || .ci/install window
	image-build/boot target/image
