import type { JSX } from 'preact';
import { useRef, useState } from 'preact/hooks';
import { refusalSentence, t } from '../i18n';
import { model, robot, rpc } from '../app';
import { readPoints, writePoints, type Point } from '../logic/points';
import { decoded, fileKind, nameOfFile, type TextForm } from '../logic/shelf';
import { addPoints, measuresOf, name, openProgram, say, shelf, text } from '../teach';
import { handOver } from '../hand_over';
import { IconButton, Sure } from './points_list';

interface Export {
  form: Exclude<TextForm, 'gcode'>;
  comma: boolean;
  label: 'file.export.sequence' | 'file.export.pos' | 'file.export.pos_comma';
}
const kEndings: Record<Export['form'], string> = { sequence: '.txt', pos: '.pos' };
/** By kind of robot: what other programs of theirs read. */
const kExports: Record<string, readonly Export[]> = {
  bigrobotarm: [{ form: 'sequence', comma: false, label: 'file.export.sequence' }],
  hexapod: [
    { form: 'pos', comma: false, label: 'file.export.pos' },
    { form: 'pos', comma: true, label: 'file.export.pos_comma' },
  ],
};

const kMost = 900_000; // bytes: a message to the server has 1 MiB at most

/** Files in and out: programs and points, whichever list is open. */
export function FileButtons({ kind }: { kind: 'program' | 'points' }): JSX.Element {
  const input = useRef<HTMLInputElement>(null);
  const [told, setTold] = useState<string | null>(null);
  const [replaces, setReplaces] = useState<readonly Point[]>([]);
  const one = model.value!;
  const read = async (file: File) => {
    const what = fileKind(file.name);
    if (what === 'foreign') {
      setTold(t('file.foreign', { command: `sinew convert ${file.name} ${nameOfFile(file.name)}.sinew --robot ${one.robot}` }));
      return;
    }
    if (what === 'unknown' || file.size > kMost) {
      setTold(t(what === 'unknown' ? 'file.unknown' : 'file.large', { file: file.name }));
      return;
    }
    const content = decoded(new Uint8Array(await file.arrayBuffer()));
    setTold(null);
    if (what === 'sequence' || what === 'pos' || what === 'gcode') {
      const rows = await converted('program.import', { text: content, form: what });
      if (rows === null) return;
      openProgram(nameOfFile(file.name), rows);
      say('prog.opened', { name: nameOfFile(file.name) });
      return;
    }
    if (what === 'program') {
      openProgram(nameOfFile(file.name), content.replace(/\r\n?/g, '\n'));
      say('prog.opened', { name: nameOfFile(file.name) });
      return;
    }
    const { points, complaints } = readPoints(content);
    const ours = points.filter((point) => point.robot === one.robot && (point.point.place || point.point.joints?.length === one.joints.length));
    if (complaints.length > 0) {
      const first = complaints[0]!;
      setTold(t('file.points.wrong', { line: first.line, text: first.text }));
      return;
    }
    const all = ours.map((point) => point.point);
    const known = new Set(shelf.peek().points.map((point) => point.name));
    addPoints(all.filter((point) => !known.has(point.name)));
    // Others use these too, where they stand now.
    setReplaces(all.filter((point) => known.has(point.name)));
    setTold(t('file.points.read', { count: ours.length, others: points.length - ours.length }));
  };
  /** By the controller; null: refused, which is told. */
  const converted = async (method: 'program.import' | 'program.export', params: object): Promise<string | null> => {
    try {
      return (await rpc.call<{ text: string }>(method, { robot: robot.value, ...params })).text;
    } catch (error) {
      setTold(refusalSentence(error as Error));
      return null;
    }
  };
  const saveAs = async ({ form, comma }: Export) => {
    setTold(null);
    const made = await converted('program.export', { text: text.value, form, decimal_comma: comma });
    if (made !== null) handOver(`${name.value || 'program'}${kEndings[form]}`, made);
  };
  const save = () => {
    if (kind === 'program') handOver(`${name.value || 'program'}.sinew`, text.value);
    else handOver('points.toml', writePoints(one.robot, shelf.value.points, measuresOf(one)));
  };
  return (
    <>
      <span class="row tight">
        <IconButton icon="folder" label={t(`file.import.${kind}`)} onClick={() => input.current?.click()} />
        <IconButton
          icon="save"
          label={t(`file.export.${kind}`)}
          disabled={kind === 'program' ? text.value.trim() === '' : shelf.value.points.length === 0}
          onClick={save}
        />
        {kind === 'program' &&
          (kExports[one.robot] ?? []).map((way) => (
            <button
              type="button"
              class="quiet"
              key={way.label}
              title={t(way.label)}
              aria-label={t(way.label)}
              disabled={text.value.trim() === ''}
              onClick={() => void saveAs(way)}
            >
              {way.comma ? `${kEndings[way.form]} 1,5` : kEndings[way.form]}
            </button>
          ))}
        <input
          ref={input}
          type="file"
          hidden
          aria-label={t(`file.import.${kind}`)}
          accept=".sinew,.toml,.txt,.pos,.gcode,.nc,.ngc,.tap,.g,.cfg,.mcap"
          onChange={(event) => {
            const file = event.currentTarget.files?.[0];
            if (file) void read(file);
            event.currentTarget.value = '';
          }}
        />
      </span>
      {told && (
        <p class="file-told" role="status">
          {told}
        </p>
      )}
      {replaces.length > 0 && (
        <Sure
          text={t('file.points.replace', { names: replaces.map((point) => point.name).join(', ') })}
          onYes={() => addPoints(replaces)}
          onEnd={() => setReplaces([])}
        />
      )}
    </>
  );
}
