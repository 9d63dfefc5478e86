/** Which procedure this tab has begun, so that it knows it again behind a reload. */
import type { ProcedureJson } from '../logic/procedure';

const kKey = 'sinew.procedure';
const nameOf = (one: ProcedureJson): string => `${one.robot}/${one.kind}/${one.number}`;

export const keepOwn = (one: ProcedureJson): void => sessionStorage.setItem(kKey, nameOf(one));
export const isOwn = (one: ProcedureJson): boolean => sessionStorage.getItem(kKey) === nameOf(one);
export const forgetOwn = (): void => sessionStorage.removeItem(kKey);
