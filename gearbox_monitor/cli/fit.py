# Copyright 2026 gearbox_monitor authors
# SPDX-License-Identifier: Apache-2.0

"""
Fit to recordings: the values of a model file, the noise of a filter, or both of one unit.

model: all values of the drive (or those named with --free), each within physical bounds and held
weakly at the value of the model file, which must be right within a factor of about ten. A search
by the innovations of a filter, as in diagnose, begins at these values and at those of the balance
of torques. Values whose free runs are farther off than those of the model file are no solution
(exit code 3). With --windows free runs are fitted, in which torque that no model explains counts
as misfit. Values that the recordings do not determine are listed and stay near their start.

noise: R and Q of a filter, as a parameter file. R comes from half a second at standstill; without
one it is estimated together with Q, by maximising the likelihood of the prediction errors. No
truth is read, and the result does not depend on --params. Record 5 s of work, better 20 s. Unless
--params or the bag states a law of tau_K, the file selects tau_k_model "mixed".

unit: model and noise of one unit, without a torque sensor. The folder --out then holds drive.yaml
and params.yaml for node and replay; tolerances state what stays open.

names: m1 m2 (inertias) D (damping) Cv Cc (friction) K (stiffness) b (half gap), kt
(torque_constant: torque per A of effort, 1 if the effort is a torque), u0 (torque offset), zero
(of the encoders), kp ki kd kff kaff (gains of a servo), and ids of effects that the model file
has (all their parameters; torque_gain goes into torque_constant). Without a known load, torque
constant, inertia, friction and stiffness share one scale: fix one of them.

usage examples:
  gearbox_monitor fit model BAG BAG2 --model drive.yaml --free m1 Cv Cc u0 --validate BAG3
  gearbox_monitor fit model BAG --model drive.yaml --windows 20 --out drive.fitted.yaml
  gearbox_monitor fit noise BAG --model drive.yaml --params start.yaml --out params.yaml
  gearbox_monitor fit unit BAG BAG2 --model drive.yaml --out unit7
"""
from argparse import Namespace
from collections.abc import Iterable, Mapping, Sequence
import math
from pathlib import Path
from typing import Any


from gearbox_monitor.cli.options import (
    estimator_options, load_recordings, opened, refuse, settings_of, show, warn)
from gearbox_monitor.diagnosis.joint.nominal import FittedValue
from gearbox_monitor.errors import InputError
from gearbox_monitor.estimation.tune import tune
from gearbox_monitor.files.user_files import (
    error_words, expect_new_file, expect_outside_of_bag, load_parameters, plain, save_model,
    write_parameters)
from gearbox_monitor.library.identify import adapt, fit, write_adapted
from gearbox_monitor.library.progress import progress_bar
from gearbox_monitor.parameters import ESTIMATOR, EstimatorParameters, MIXED, MODEL as MODEL_VALUES
from gearbox_monitor.presentation import credible, number, on_axis, percent
from gearbox_monitor.recordings.joint_input import find_input, NO_MODEL, samples_of
from gearbox_monitor.report.sentences import of_fit, of_noise, of_unit, say, told, UNITS, wrapped
from gearbox_monitor.signals.examine import measured_samples

MODEL, NOISE, UNIT = WHAT = ('model', 'noise', 'unit')
# Options that not all of them take, by those that do; fit noise reads joints by --params.
OF = {(MODEL,): ('free', 'validate', 'windows'),
      (NOISE,): ('filter', 'fix_speeds'), (NOISE, UNIT): ('params',),
      (MODEL, UNIT): ('joint', 'model_arm_joint', 'keyframe', 'actuator', 'root', 'values',
                      'motor_joint', 'arm_joint', 'setpoint_joint')}
FIGURES = 'correlated', 'covariance', 'gap_before', 'gap_after', 'validation'
SECONDS, WHEN = 1.0, ('before', 'after')
SAME = 1.0     # of log-likelihood: parameters as good as tuned ones
UNDECIDED = 3


def run(args: Namespace) -> int:
    """Run the command with the options `args`; returns the exit code."""
    for takers, names in OF.items():
        if args.what not in takers:
            refuse(args, names, f'of fit {" and fit ".join(takers)}, expected none with fit '
                   f'{args.what}')
    if args.what != NOISE and args.model is None:
        raise InputError(f'--model: missing, fit {args.what} needs it')
    if args.what != MODEL and args.out is None:
        raise InputError(f'--out: missing, fit {args.what} needs it')
    return {MODEL: _fit_model, NOISE: _fit_noise, UNIT: _fit_unit}[args.what](args)


def _lines(data: Mapping[str, Any], heads: Sequence[str], rows: Iterable[Sequence[str]],
           *notes: str) -> str:
    """Return the summary of `data`, a table under `heads` and `notes` as lines for people."""
    listed = [('', *heads), *rows]
    wide = max(len(row[0]) for row in listed) + 1
    return '\n'.join([
        *wrapped(data['summary']), '',
        *(f'{name:{wide}s}{a:>12s}{b:>12s} {c:>12s}  {" ".join(more)}'.rstrip()
          for name, a, b, c, *more in listed),
        *notes, *(f'note: {note}' for note in data['notes'])])


def _value_rows(values: Iterable[FittedValue]) -> list[tuple[str, ...]]:
    """Return the row of each of the fitted `values`."""
    return [(v.name, f'{v.start:.5g}', *credible(v.value, v.error).digits(), f'{v.unit:10s}',
             '' if v.determined else 'not identified') for v in values]


def _values(values: Iterable[FittedValue]) -> dict[str, Any]:
    return {v.name: {k: x for k, x in vars(v).items() if k != 'name'} for v in values}


# ---------------------------------------------------------------------- model

def _fit_model(args: Namespace) -> int:
    """Fit the values of a model file; return the exit code."""
    if not args.windows >= SECONDS:
        raise InputError(f'--windows: {args.windows:g}, expected at least {SECONDS:g} s')
    expect_new_file(args.out)
    model, recordings, validate, notes = load_recordings(args)
    result = fit(recordings, model, args.free, validate=validate,
                 seconds=args.windows if args.windows > SECONDS else None)
    if args.out:
        save_model(args.out, result.model, ['Fitted with gearbox_monitor fit model to '
                                            + ', '.join(Path(path).name for path in args.bag)])
    data = plain({
        'values': _values(result.values),
        **{name: getattr(result, name) for name in FIGURES},
        'process_torque_time': None if model.driven_by == 'position' else (
            result.model.process_torque_time), 'notes': notes})
    data = {**told(of_fit(result)), **data}
    lines = [say('hardly_apart', first=first, second=second, r=r)
             for first, second, r in result.correlated]
    if data['process_torque_time']:
        lines.append(say('likeliest_time', seconds=data['process_torque_time']))
    if validation := data['validation']:
        lines.append(say('misfit_elsewhere', name=Path(args.validate).name,
                         **{when: number(validation[f'gap_{when}']) for when in WHEN}))
        runs = validation['free_run']
        lines += ['  ' + say('free_run_of_fit', seconds=runs['seconds'], name=name, **{
            when: _rms(runs[when][name]) for when in WHEN}) for name in runs['before']
            if any(runs[when][name] is not None for when in WHEN)]
    if args.out:
        lines.append(f'written: {args.out}')
    show(args, data, lambda: _lines(data, ('model file', 'fitted', '±', 'unit'),
                                    _value_rows(result.values), *lines))
    return 0 if all(v.determined for v in result.values) else 1


def _rms(value: float | None) -> str:
    return 'diverges' if value is None or not math.isfinite(value) else f'{number(value)} rms'


# ---------------------------------------------------------------------- unit

def _fit_unit(args: Namespace) -> int:
    """Fit model and noise of one unit; return the exit code."""
    folder = Path(args.out)
    if folder.exists() or not folder.parent.is_dir():
        raise InputError(f'--out {folder}: expected a new folder in one that exists')
    expect_outside_of_bag(folder)
    values = load_parameters(args.params, 'estimator', ESTIMATOR) if args.params else {}
    values.pop('model', None)
    model, recordings, _, notes = load_recordings(args)
    parameters = EstimatorParameters.of({
        'motor_joint': args.motor_joint, 'arm_joint': args.arm_joint, 'tau_k_model': MIXED,
        **values})
    result = adapt(recordings, model, parameters=parameters)
    write_adapted(folder, result, ', '.join(Path(path).name for path in args.bag))
    fitted = result.fit.values if result.fit else ()
    data = plain({
        'values': _values(fitted), 'covariance': result.fit.covariance if result.fit else None,
        'gap_after': result.fit.gap_after if result.fit else None,
        'tolerances': result.tolerances, 'parameters': result.parameters, 'open': result.open,
        'notes': notes})
    data = {**told(of_unit(result)), **data}
    before = result.tuning.get('before_parameters', {})
    rows = [*_value_rows(fitted), *(
        (name, f'{start:.4g}', f'{now:.4g}', '')
        for name, (start, now) in result.tolerances.items()), *(
        (name, f'{before.get(name, 0.0):.5g}', f'{value:.5g}', '', UNITS[name])
        for name, value in result.parameters.items() if not isinstance(value, str))]
    show(args, data, lambda: _lines(
        data, ('model file', 'this unit', '±', 'unit'), rows,
        *(f'open: {sentence}' for sentence in result.open),
        f'written: {folder / "drive.yaml"}, {folder / "params.yaml"}'))
    if result.fit is None:
        return UNDECIDED
    return int(bool(result.kept) or bool(result.tuning.get('kept')))


# ---------------------------------------------------------------------- noise

def _fit_noise(args: Namespace) -> int:
    """Fit R and Q of a filter; return the exit code."""
    expect_new_file(args.out)
    if len(args.bag) > 1:
        raise InputError(f'{len(args.bag)} recordings, fit noise expected one')
    args.bag, = args.bag
    given, model_file = estimator_options(args)
    if args.filter:
        given['filter'] = args.filter
    with opened(args) as reader:
        source = find_input(reader, args.topic)
        model, parameters, is_known = settings_of(
            args, reader, source, given, model_file, {'tau_k_model': MIXED})
        samples, _ = samples_of(reader.joint_states(
            source.topic, (parameters.motor_joint, parameters.arm_joint)), model)
    samples, notes = measured_samples(samples, args.bag)
    notes = [NO_MODEL] * (not is_known) + list(filter(None, [reader.notice])) + notes
    with progress_bar('fit') as progress:
        try:
            data = tune(model, parameters, [samples], not args.fix_speeds,
                        lambda share: progress(share, 1))
        except InputError as error:
            raise InputError(f'{args.bag}: {error}') from None
    data.update(bag=args.bag, out=args.out, notes=data['notes'] + notes)
    axis = model.axis
    data = {**told(of_noise(data, axis)), **data}
    write_parameters(args.out, parameters, (model_file, {
        row.name: given[row.name] for row in MODEL_VALUES if row.name in given}), data)
    warn(args, data['notes'])
    show(args, data, lambda: _lines(
        data, ('before', 'after', '±', 'unit'), _noise_rows(data, axis),
        say('starts_agree', share=percent(data['spread']), **data),
        f'open: {data["unidentifiable"]}', f'written: {args.out}'))
    return int(data['kept_by'] > SAME)


def _noise_rows(data: Mapping[str, Any], axis: str) -> list[tuple[str, ...]]:
    """Return rows with the scores before and after, and each parameter of a drive with `axis`."""
    start, tuned = data['before'], data['after']
    rows: list[tuple[Any, Any, Any, str, str]] = [
        ('log-likelihood', start['loglik'], tuned['loglik'], '', ''),
        ('mean NIS', start['nis'], tuned['nis'], '',
         '95 % band {:.3f}..{:.3f}'.format(*data['nis_band']))]
    rows += [(f'Ljung-Box, {name}', start['ljung_box'][k], tuned['ljung_box'][k], '',
              f'white below {data["white_limit"]:.1f}; autocorrelation '
              f'{data["autocorrelation"][k]:.2g} per lag') for k, name in enumerate((
                  'motor', 'arm'))]
    rows += [(name, data['before_parameters'][name], value,
              error_words(data['relative_error'].get(name)).lstrip(' ±,'),
              on_axis(UNITS[name], axis)) for name, value in data['parameters'].items()]
    return [(name, _cell(before), _cell(after), *more) for name, before, after, *more in rows]


def _cell(value: Any) -> str:
    if isinstance(value, str):
        return value
    if value is None or not math.isfinite(value):
        return 'none'
    return f'{value:.5g}' if abs(value) < 1e4 else f'{value:.1f}'
