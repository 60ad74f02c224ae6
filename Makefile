# luxpipe: build, test, demonstrate. `make demo` leaves finished pictures in out/.

CARGO ?= cargo
PREFIX ?= /usr/local
FILTERS := $(notdir $(basename $(wildcard src/bin/*.rs)))
PROGRAM_PREFIX ?=
RULES := $(patsubst pipelines/%.toml,out/rules/%.mk,$(wildcard pipelines/*.toml))
BIN := target/release
FUZZ_TARGETS := $(notdir $(basename $(wildcard fuzz/fuzz_targets/*.rs)))
FUZZ_SECONDS ?= 60
FUZZ_LIMITS := -rss_limit_mb=512 -timeout=10 -max_len=65536

.PHONY: all demo test lint fuzz bench bench-rays bench-render bench-methods bench-effects bench-media bench-plan tradeoff tradeoff-quick references stability paper-relative mesh accuracy man paper-colour paper-encodings paper-tone paper intents test-hostile test-faults test-names test-determinism load load-small audit sbom install clean

all:
	$(CARGO) build --release --locked

# luxpipe knows what each pipeline depends on: scenes, their meshes and spectra, other pictures.
demo: all $(RULES)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(MAKE) --no-print-directory $(RULES:%=-f %) $(notdir $(basename $(RULES)))
	@ls -l out/*.png

# A picture by its name is made again when its pipeline, or anything that goes into it, has changed.
out/%.png: all $(RULES)
	@PATH="$(CURDIR)/$(BIN):$$PATH" $(MAKE) --no-print-directory $(RULES:%=-f %) $@

out/rules/%.mk: pipelines/%.toml all
	@mkdir -p $(@D)
	@$(BIN)/luxpipe --make $< > $@

$(BIN)/luxpipe: Cargo.toml Cargo.lock build.rs $(shell find src -name '*.rs')
	$(CARGO) build --release --locked

test:
	$(CARGO) test --locked

lint:
	$(CARGO) fmt --check
	$(CARGO) clippy --locked --all-targets -- -D warnings

# Damaged input for every decoder, FUZZ_SECONDS each, grown from tests/data and tests/bad. Any toolchain will do: no sanitizer.
fuzz:
	@$(CARGO) fuzz --version > /dev/null 2>&1 || { echo "make fuzz needs cargo-fuzz: $(CARGO) install cargo-fuzz --locked"; exit 1; }
	for target in $(FUZZ_TARGETS); do mkdir -p fuzz/corpus/$$target && $(CARGO) fuzz run --sanitizer none $$target \
		fuzz/corpus/$$target tests/data tests/bad pipelines scenes displays -- -max_total_time=$(FUZZ_SECONDS) $(FUZZ_LIMITS) || exit 1; done

# Ratios to `cat`, and of encodings and tone maps to Radiance and libtiff, in the same run: see benches/.
bench:
	$(CARGO) bench --locked --bench streams --bench encodings --bench tone

# Rays a second; beside Embree's where EMBREE_RAYS names a program made of benches/embree_rays.cpp.
bench-rays:
	$(CARGO) bench --locked --bench rays

# spectrace beside the Mitsuba of MITSUBA_PYTHON (docs/performance.md); PART=cornell, mesh, fog, bands, cost or pools for one.
bench-render:
	$(CARGO) bench --locked --bench render -- $(PART)

# The ways to solve Eq. (1), error beside time: docs/methods.csv and docs/methods.svg; PART=room, cornell, caustic or local for one.
bench-methods: all
	$(CARGO) bench --locked --bench methods -- $(PART)
	target/release/pplot --chart docs/methods.csv --x seconds --y error_percent --by method --log \
		--title "Irradiance in a closed room" --labels "seconds,mean absolute error in %" docs/methods.svg

# What polarization, fluorescence and dispersion cost; EFFECTS_BEFORE=PROGRAM counts scenes without any beside an earlier spectrace.
bench-effects: all
	$(CARGO) bench --locked --bench effects

# Random rooms by their plans and in full bands on the same paths.
bench-plan:
	$(CARGO) bench --locked --bench plan

# Error against time for every method and plan on the suite: out/tradeoff/tradeoff.html, .csv and charts (up to 20 minutes).
SUITE := $(patsubst %,scenes/%.toml,cornell room-c glossy caustic fogbox fluorescence spiky mesh tower)
tradeoff: all mesh
	$(BIN)/tradeoff $(SUITE) --width 160 --seconds 2 --reference-seconds 30 --filters -o out/tradeoff

# The same 64 pixels wide against references that are kept in scenes/references (under 2 minutes).
QUICK := --width 64 --references scenes/references
tradeoff-quick: all mesh
	$(BIN)/tradeoff $(SUITE) $(QUICK) --seconds 0.4 --filters -o out/tradeoff-quick

# Those, for good: a minute a scene. Take scenes/references away first where a mesh or a spectrum changed.
references: all mesh
	$(BIN)/tradeoff $(SUITE) $(QUICK) --methods none --plans none --reference-seconds 60 -o out/references

# Every documented failure case of every method, as a table, into docs/limits.md.
stability:
	STABILITY_WRITE=1 $(CARGO) test --locked --release --test stability -- --nocapture

# The paper's relative colours on rendered scenes: docs/paper-relative-*.csv and their charts; the page on standard output.
paper-relative: all
	@$(CARGO) run --locked --quiet --release --example relative -- docs/paper-relative
	@for kinds in one two three; do $(BIN)/pplot --chart docs/paper-relative-$$kinds.csv --x seconds --y delta_e_rms --by model --log-y \
		--title "Ways to carry colour, kinds of lamp: $$kinds" --labels "seconds,Delta E 2000 (root mean square)" docs/paper-relative-$$kinds.svg; done

docs/paper-relative.md: $(wildcard examples/relative/*)
	$(MAKE) --no-print-directory --silent paper-relative > $@.part
	mv $@.part $@

# The solvers of Eq. (2), error beside time; the march's steps; the dipole beside transport. PART=fog, steps or dipole for one.
bench-media: all
	$(CARGO) bench --locked --bench media -- $(PART)
	target/release/pplot --chart docs/media.csv --x seconds --y error_percent --by method --log \
		--title "A cube of fog by four solvers" --labels "seconds,mean absolute error of pixels in %" docs/media.svg
	target/release/pplot --chart docs/media-steps.csv --x step --y error_percent --by case --log \
		--title "Marching: single scattering in a slab" --labels "optical depth of a step,error in %" docs/media-steps.svg
	target/release/pplot --chart docs/media-dipole.csv --x reduced_albedo --y error_percent --by medium \
		--title "The dipole against transport" --labels "reduced albedo,error in %" docs/media-dipole.svg

# The meshes of scenes/mesh.toml, 211,722 triangles from formulas, into out/mesh.
mesh:
	@$(CARGO) run --locked --quiet --release --example mesh

# Every case of tests/ref/validation.toml to its tolerance, into docs/accuracy.md.
accuracy:
	$(CARGO) bench --locked --bench accuracy

# The paper's colour figures beside ours, as Markdown.
paper-colour:
	@$(CARGO) run --locked --quiet --release --example paper_colour

docs/paper-colour.md: examples/paper_colour.rs $(wildcard examples/colour/*.rs)
	$(MAKE) --no-print-directory --silent paper-colour > $@.part
	mv $@.part $@

# What each encoding of light keeps and costs, as Markdown.
paper-encodings:
	@$(CARGO) run --locked --quiet --release --example paper_encodings

docs/encodings.md: examples/paper_encodings.rs $(wildcard examples/encodings/*) benches/picture/mod.rs
	$(MAKE) --no-print-directory --silent paper-encodings > $@.part
	mv $@.part $@

# The paper's Figures 3 to 8 from one render of the control tower: out/paper/tone.html shows them side by side.
TONE := out/paper
TONE_SAMPLES ?= 256
LINEAR ?= -l
VISIBILITY ?= -h
PRINT ?= --print --display print
NAMED = --curve "linear, clamped=$(TONE)/linear.map" --curve "visibility=$(TONE)/visibility.map" --curve "print=$(TONE)/print.map"
MAPS := $(TONE)/linear.map $(TONE)/visibility.map $(TONE)/print.map

paper-tone: $(TONE)/tone.html
	@ls -l $(TONE)

$(TONE)/tone.html: docs/tone-figures.html $(patsubst %,$(TONE)/figure%.png,3 4 5 6 7 8) $(patsubst %,$(TONE)/figure%.svg,6 7 8)
	cp $< $@

# The master, and what the three operators see of it.
$(TONE)/tower.tif: scenes/tower.toml $(wildcard scenes/tower/*.obj spectra/*.csv) $(BIN)/luxpipe
	@mkdir -p $(TONE)
	$(BIN)/spectrace --samples $(TONE_SAMPLES) $< | $(BIN)/ra_loglv - $@

$(TONE)/tower.lux: $(TONE)/tower.tif
	$(BIN)/vonkries --to D65 $< $@

$(TONE)/tower-print.lux: $(TONE)/tower.tif
	$(BIN)/vonkries --display print $< $@

$(TONE)/linear.map: $(TONE)/tower.lux
	$(BIN)/pcond $(LINEAR) -x $@ $< > /dev/null

$(TONE)/visibility.map: $(TONE)/tower.lux
	$(BIN)/pcond $(VISIBILITY) -x $@ $< > /dev/null

$(TONE)/print.map: $(TONE)/tower-print.lux
	$(BIN)/pcond $(PRINT) -x $@ $< > /dev/null

$(TONE)/figure3.png: $(TONE)/tower.lux
	$(BIN)/pcond $(LINEAR) $< | $(BIN)/xyz2rgb --gamut compress | $(BIN)/ra_png - $@

$(TONE)/figure4.png: $(TONE)/tower.lux
	$(BIN)/pcond $(VISIBILITY) $< | $(BIN)/xyz2rgb --gamut compress | $(BIN)/ra_png - $@

# Codes for the print's own primaries and white, which the PNG states.
$(TONE)/figure5.png: $(TONE)/tower-print.lux
	$(BIN)/pcond $(PRINT) $< | $(BIN)/xyz2rgb --display print --gamut compress | $(BIN)/ra_png --display print - $@

$(TONE)/figure6.svg $(TONE)/figure6.png: $(MAPS) $(BIN)/luxpipe
	$(BIN)/pplot $(NAMED) --x-range 1:30000 $@

$(TONE)/figure7.svg $(TONE)/figure7.png: $(MAPS) $(BIN)/luxpipe
	$(BIN)/pplot $(NAMED) --zoom 200 $@

$(TONE)/figure8.svg $(TONE)/figure8.png: $(TONE)/print.map $(TONE)/tower.lux $(BIN)/luxpipe
	$(BIN)/pplot --curve "print=$(TONE)/print.map" --histogram $(TONE)/tower.lux --x-range 0:4.5 $@

# The paper's sections with our figures and numbers beside its claims, all on one page: out/paper/index.html.
TRADES := cornell-colour caustic-colour spiky-plans
paper: $(TONE)/index.html
	@ls -l $<

$(TONE)/index.html: $(wildcard examples/paper_page/* docs/*.md docs/*.svg) docs/claims.csv $(TONE)/tone.html $(TONE)/blueflower.svg \
		$(patsubst %,$(TONE)/tradeoff-%.svg,$(TRADES))
	@$(CARGO) run --locked --quiet --release --example paper_page -- $(TONE)

$(TONE)/tradeoff-%.svg: out/tradeoff-quick/tradeoff.csv
	@mkdir -p $(TONE)
	cp out/tradeoff-quick/$*.svg $@

out/tradeoff-quick/tradeoff.csv: $(SUITE) $(BIN)/luxpipe
	$(MAKE) --no-print-directory tradeoff-quick

# The reflectance of BlueFlower and its products with three lights, each 1 at 560 nm.
$(TONE)/blueflower.csv: spectra/cc_ohta_05_blue_flower.csv $(patsubst %,spectra/illuminant_%.csv,A B D65)
	@mkdir -p $(TONE)
	awk -F, 'BEGIN { print "wavelength_nm,reflectance,under A,under B,under D65" } FNR == 1 { file++ } /^[0-9]/ { of[file, $$1 + 0] = $$2 } \
		END { for (nm = 380; nm <= 780; nm += 5) { printf "%d,%g", nm, of[1, nm]; \
		for (i = 2; i <= 4; i++) printf ",%g", of[1, nm] * of[i, nm] / of[i, 560]; print "" } }' $^ > $@

$(TONE)/blueflower.svg: $(TONE)/blueflower.csv $(BIN)/luxpipe
	$(BIN)/pplot --chart $< --x wavelength_nm --y reflectance --y "under A" --y "under B" --y "under D65" \
		--title "BlueFlower: its reflectance, and what it sends back of A, B and D65" \
		--labels "wavelength in nm,reflectance; product with a light of 1 at 560 nm" $@

# What the gamut methods and intents of xyz2rgb do to colours outside, as Markdown.
intents:
	@$(CARGO) run --locked --quiet --release --example intents

docs/gamut.md: examples/intents.rs $(wildcard examples/gamut/*) tests/ref/pointer_gamut.csv
	$(MAKE) --no-print-directory --silent intents > $@.part
	mv $@.part $@

TRUST = $(CARGO) bench --locked --bench trust --
COUNT ?= 2000
SEED ?= 1

# COUNT damaged files a program, by lot from SEED: under 10 minutes on 2 cores; what breaks a demand is kept in target/trust.
test-hostile:
	$(TRUST) hostile --count $(COUNT) --seed $(SEED)

# Full disks, closed pipes, signals, shrinking files, little memory: each program by each fault. As root all of them, else what can be done.
test-faults:
	$(TRUST) faults

# Odd names, terminal escapes, markup: nothing is run, nothing is obeyed.
test-names:
	$(TRUST) names

# Equal input, equal bytes.
test-determinism:
	$(TRUST) determinism

# A gigapixel, 10,000 frames, 200 pipelines, 10 million triangles: minutes, and 18 GB of /var/tmp. Not for CI; load-small is a 64th.
load:
	$(TRUST) load

load-small:
	$(TRUST) load --small

# Licences, sources and advisories of all dependencies (deny.toml); without the network no advisories.
audit:
	@if ! $(CARGO) deny --version > /dev/null 2>&1; then echo "skipped: make audit needs cargo-deny (cargo install cargo-deny --locked)"; \
	elif $(CARGO) deny fetch db > /dev/null 2>&1; then $(CARGO) deny --locked check; \
	else $(CARGO) deny --locked --offline check bans licenses sources && \
		echo "skipped: advisories, which need the network"; fi

# Every crate that the programs are built of, with version, licence and checksum, as CSV: out/sbom.csv.
sbom:
	@mkdir -p out
	@$(CARGO) metadata --locked --format-version 1 --filter-platform $$(rustc -vV | sed -n 's/^host: //p') > out/metadata.json
	@$(CARGO) tree --locked --edges normal,build --prefix none --format '{p},{l}' | sed 's/ (\*)//; s/ (proc-macro)//; s/ (\/[^)]*)//; s/ v/,/' | sort -u > out/crates.csv
	@awk -F'"' '/^name = /{n=$$2} /^version = /{v=$$2} /^checksum = /{print n "," v "," $$2}' Cargo.lock > out/sums.csv
	@awk -F, 'BEGIN { print "crate,version,licence,sha256" } FNR == NR { sum[$$1 "," $$2] = $$3; next } { print $$1 "," $$2 "," $$3 "," sum[$$1 "," $$2] }' \
		out/sums.csv out/crates.csv > out/sbom.csv
	@rm out/sums.csv out/crates.csv
	@echo "out/sbom.csv: $$(($$(wc -l < out/sbom.csv) - 1)) crates; out/metadata.json: cargo's own"

man: all
	@$(CARGO) run --locked --quiet --release --example manuals -- out/man $(PROGRAM_PREFIX)

# PREFIX is where, PROGRAM_PREFIX what stands in front of every name (lux- makes lux-pcond, beside Radiance's pcond); DESTDIR for packagers.
install: all
	@rm -rf out/man
	@$(MAKE) --no-print-directory man
	@for f in $(FILTERS); do name=$(PROGRAM_PREFIX)$$f; old=$$(command -v $$name || true); \
		case "$$old" in ""|"$(PREFIX)/bin/$$name") ;; *) \
		echo "warning: $(PREFIX)/bin/$$name and $$old have one name: the one that comes first on PATH counts (PROGRAM_PREFIX=lux- avoids it)" >&2;; esac; done
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/share/man/man1
	for f in $(FILTERS); do install -m 755 $(BIN)/$$f $(DESTDIR)$(PREFIX)/bin/$(PROGRAM_PREFIX)$$f || exit 1; done
	install -m 644 out/man/man1/*.1 $(DESTDIR)$(PREFIX)/share/man/man1
	for d in bash:share/bash-completion/completions zsh:share/zsh/site-functions fish:share/fish/vendor_completions.d; do \
		install -d $(DESTDIR)$(PREFIX)/$${d#*:} && install -m 644 out/man/$${d%%:*}/* $(DESTDIR)$(PREFIX)/$${d#*:} || exit 1; done

clean:
	$(CARGO) clean
	rm -rf out
