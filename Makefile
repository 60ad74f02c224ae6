# luxpipe: build, test, demonstrate. `make demo` leaves finished pictures in out/.

CARGO ?= cargo
PREFIX ?= /usr/local
FILTERS := $(notdir $(basename $(wildcard src/bin/*.rs)))
PICTURES := $(patsubst pipelines/%.toml,out/%.png,$(wildcard pipelines/*.toml))
BIN := target/release
FUZZ_TARGETS := $(notdir $(basename $(wildcard fuzz/fuzz_targets/*.rs)))
FUZZ_SECONDS ?= 60
FUZZ_LIMITS := -rss_limit_mb=512 -timeout=10 -max_len=65536

.PHONY: all demo test lint fuzz bench man paper-colour paper-encodings intents install clean

all:
	$(CARGO) build --release --locked

demo: all
	@mkdir -p out
	@$(MAKE) --no-print-directory $(PICTURES)
	@ls -l $(PICTURES)

# A picture is rebuilt when its pipeline, a scene, a spectrum or the program changed.
out/%.png: pipelines/%.toml $(wildcard scenes/*.toml) $(wildcard spectra/*.csv) $(BIN)/luxpipe
	@mkdir -p out
	$(BIN)/luxpipe $<

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

# Ratios to `cat`, and of the encodings to Radiance and libtiff, in the same run: see benches/.
bench:
	$(CARGO) bench --locked --bench streams --bench encodings

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

# What the gamut methods and intents of xyz2rgb do to colours outside, as Markdown.
intents:
	@$(CARGO) run --locked --quiet --release --example intents

docs/gamut.md: examples/intents.rs $(wildcard examples/gamut/*) tests/ref/pointer_gamut.csv
	$(MAKE) --no-print-directory --silent intents > $@.part
	mv $@.part $@

man:
	$(CARGO) run --locked --quiet --release --example manuals -- out/man

install: all man
	install -d $(DESTDIR)$(PREFIX)/bin $(DESTDIR)$(PREFIX)/share/man/man1
	install -m 755 $(addprefix $(BIN)/,$(FILTERS)) $(DESTDIR)$(PREFIX)/bin
	install -m 644 out/man/man1/*.1 $(DESTDIR)$(PREFIX)/share/man/man1
	install -d $(DESTDIR)$(PREFIX)/share/bash-completion/completions
	install -m 644 out/man/bash/* $(DESTDIR)$(PREFIX)/share/bash-completion/completions

clean:
	$(CARGO) clean
	rm -rf out
